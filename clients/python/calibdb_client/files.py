"""Files that are read and written as a whole, and the picture that one is written for."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import UsageError

if TYPE_CHECKING:
    from calibsolver import image_transform

MAX_BYTES = 64 * 1024 * 1024


def write_whole(path: Path, content: bytes) -> None:
    """Write a file as a whole or not at all. Raises UsageError if it cannot be written."""
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        partial.write_bytes(content)
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise UsageError(f"{path} cannot be written: {error.strerror or error}") from None


def read_whole(path: Path) -> bytes:
    """Read a file. Raises UsageError if it cannot be read, or is too large to be a calibration."""
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror or error}") from None
    if len(content) > MAX_BYTES:
        raise UsageError(f"{path} is larger than {MAX_BYTES >> 20} MB")
    return content


def read_object(path: Path) -> dict[str, Any] | None:
    """Read a JSON object; None if the file contains anything else. Raises as `read_whole` does."""
    try:
        value = json.loads(read_whole(path))
    except (ValueError, RecursionError):
        return None
    return value if isinstance(value, dict) else None


@dataclass(frozen=True)
class ExportedFile:
    """A calibration as another tool's file.

    `error`: px, largest distance between the projections by the calibration and by the file, 0: exact.
    `coverage`: share of the image in which the file's model is valid.
    """

    content: bytes = field(repr=False)
    filename: str
    media_type: str = "application/octet-stream"
    error: float = 0.0
    coverage: float = 1.0
    warning: str = ""


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
