"""A calibration file of another program, and the format in which it is wanted."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from calibdb.schema.export import FormatName
from calibdb.schema.fields import DistortionModel, ImgSize, Label, Strict, Whole

MAX_FILE_CHARACTERS = 100_000  # of a file with one camera: most have a few hundred
MAX_FILE_CAMERAS = 64  # of a file


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
