"""Change of the picture that a file is written for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .errors import UsageError

if TYPE_CHECKING:
    from calibsolver import image_transform


@dataclass(frozen=True)
class PictureChange:
    """Change of a picture: `crop`, then `resize`, `rotate` and `mirror`.

    `crop`: left, top, width, height, px; `resize`: width, height, px; `rotate`: degrees clockwise. Raises
    UsageError for numbers that describe no picture.
    """

    crop: Sequence[int] | None = None
    resize: Sequence[int] | None = None
    rotate: int = 0
    mirror: bool = False

    def __post_init__(self) -> None:
        if self.crop is not None and len(self.crop) != 4:
            raise UsageError("crop has four numbers: left, top, width, height")
        if self.resize is not None and len(self.resize) != 2:
            raise UsageError("resize has two numbers: width, height")
        if self.rotate not in (0, 90, 180, 270):
            raise UsageError(f"rotate is 0, 90, 180 or 270, not {self.rotate}")

    def query(self) -> dict[str, str]:
        """Return the members of an export's query."""
        query = {}
        if self.crop is not None:
            query["crop"] = ",".join(str(int(each)) for each in self.crop)
        if self.resize is not None:
            query["resize"] = "x".join(str(int(each)) for each in self.resize)
        if self.rotate:
            query["rotate"] = str(self.rotate)
        if self.mirror:
            query["mirror"] = "1"
        return query

    def transform(self, img_size: tuple[int, int]) -> image_transform.Transform:
        """Return the change as a map of pixels. Raises CalibrationError for a part outside the picture."""
        from calibsolver import image_transform

        change = image_transform.identity(img_size)
        if self.crop is not None:
            x, y, w, h = (int(each) for each in self.crop)
            change = change.then(image_transform.crop(change.img_size, (x, y), (w, h)))
        if self.resize is not None:
            w, h = (int(each) for each in self.resize)
            change = change.then(image_transform.resize(change.img_size, (w, h)))
        change = change.then(image_transform.rotate(change.img_size, self.rotate))
        return change.then(image_transform.mirror(change.img_size)) if self.mirror else change


UNCHANGED = PictureChange()
