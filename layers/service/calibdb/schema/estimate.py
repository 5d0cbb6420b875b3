"""Estimate of a camera without a reliable calibration."""

from typing import Literal

from pydantic import Field

from calibdb.schema.fields import CameraMatrix, Coefficients, ImgSize, LensModel, Open, is_none

EstimateBasis = Literal["calibrations", "views", "device", "other_size", "published", "family", "population"]


class Source(Open):
    """Publication that an estimate rests on."""

    title: str = Field(description="Name of the publication.")
    url: str = Field(description="Address of the publication.")


class EstimateInterval(Open):
    """Interval that contains the true value with a probability of 90 %."""

    hfov_deg: tuple[float, float] = Field(description="Lowest and highest horizontal field of view, degrees.")


class Estimate(Open):
    """Likely camera, if nothing reliable is known. It is not a calibration: nothing of it is ever stored."""

    img_size: ImgSize
    camera_matrix: CameraMatrix
    distortion_model: LensModel
    distortion_coefficients: Coefficients
    hfov_deg: float = Field(description="Horizontal field of view, degrees.")
    interval_90: EstimateInterval
    basis: EstimateBasis = Field(
        description="Best evidence that it rests on: too few calibrations here; views that were sent; what "
        "the device reports; this camera at another size; a published value of this model; other cameras of "
        "its maker; its kind of device."
    )
    group: str | None = Field(
        None,
        exclude_if=is_none,
        description="Name of the group of calibrations that fits the views: the one that most of its "
        "contributors gave to the mode, else its field of view.",
    )
    sources: tuple[Source, ...] = Field((), description="Publications that the estimate rests on.")
