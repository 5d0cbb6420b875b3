"""Query of an export, and conversion of a calibration file."""

import re
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field

from calibdb.schema.fields import (
    MAX_IMAGE_SIDE_PX,
    DistortionModel,
    ImgSize,
    Index,
    Label,
    Open,
    Strict,
    Whole,
    camera_like,
)

# The names are the API's. `calibsolver.formats` has a class for each.
FormatName = Literal[
    "calibdb",
    "opencv-yaml",
    "opencv-json",
    "ros",
    "kalibr",
    "colmap",
    "opensfm",
    "mrcal",
    "corners-vnl",
    "gyroflow",
    "lensfun",
    "dng",
    "webxr",
    "gltf",
    "photonvision",
    "artoolkit",
]
FORMATS: tuple[str, ...] = get_args(FormatName)
MAX_FILE_CHARACTERS = 100_000  # of a file with one camera: most have a few hundred
MAX_FILE_CAMERAS = 64
_NUMBER = re.compile("[0-9]{1,9}")


def _numbers(separator: str, count: int | None = None) -> BeforeValidator:
    """Parse whole numbers; any number of them are the indices of views."""
    what = "indices of views" if count is None else f"{count} whole numbers"

    def parse(value: Any) -> Any:
        if not isinstance(value, str):
            return value
        parts = value.split(separator)
        if count not in (None, len(parts)) or not all(_NUMBER.fullmatch(part) for part in parts):
            raise ValueError(f"must be {what} with {separator!r} between them")
        return tuple(int(part) for part in parts)

    return BeforeValidator(parse)


MIN_SIDE_PX = 64
"""Side of an image after a crop or resize: smaller ones determine no lens."""
Position = Annotated[int, Field(ge=0, le=MAX_IMAGE_SIDE_PX)]
Side = Annotated[int, Field(strict=True, ge=MIN_SIDE_PX, le=MAX_IMAGE_SIDE_PX), Whole]
Size = Annotated[tuple[Side, Side], AfterValidator(camera_like)]


class ExportQuery(Open):
    """Query of an export. The image is cut, then resized, then turned, then mirrored."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)

    format: FormatName = Field("calibdb", description="File format.")
    crop: Annotated[tuple[Position, Position, Side, Side] | None, _numbers(",", 4)] = Field(
        None,
        description="Left, top, width and height of the part that is cut out first, px; at least 64 x 64.",
        examples=["160,0,960,720"],
    )
    resize: Annotated[Size | None, _numbers("x", 2)] = Field(
        None, description="Width and height to which the picture, or the part, is then scaled."
    )
    rotate: Annotated[
        Literal[0, 90, 180, 270],
        BeforeValidator(lambda v: int(v) if str(v) in ("0", "90", "180", "270") else v),
    ] = Field(0, description="Degrees, clockwise, after that.")
    mirror: bool = Field(False, description="True: left and right are swapped, as the last step.")
    without: Annotated[tuple[Index, ...], _numbers(",")] = Field(
        (),
        max_length=64,
        description=(
            "Indices of views that are left out: what the calibration would be had they not been taken."
        ),
        examples=["4,7"],
    )

    @property
    def plain(self) -> bool:
        """True if the format is our own and the image is not changed."""
        return self.format == "calibdb" and not (self.crop or self.resize or self.rotate or self.mirror)


class ConvertRequest(Strict):
    """A calibration file, and what it does not say. Nothing of it is stored."""

    file: str = Field(
        min_length=1,
        max_length=MAX_FILE_CHARACTERS,
        description="Content of the file: a camera matrix and distortion. Corners in it are kept in "
        "`photonvision` only.",
    )
    encoding: Literal["text", "base64"] = Field("text", description="`base64` of a numpy archive (.npz).")
    format: FormatName = Field("calibdb", description="Requested format.")
    img_size: ImgSize | None = Field(None, description="Size of the images, if the file lacks it.")
    distortion_model: DistortionModel | None = Field(
        None, description="Model of four coefficients without a name: `rectilinear` or `fisheye`."
    )
    number: Annotated[int, Field(strict=True, ge=0, lt=MAX_FILE_CAMERAS), Whole] = Field(
        0, description="Number of the camera in a file with several, from 0."
    )
    camera: Label | None = Field(None, description="Name of the camera in the new file.")
