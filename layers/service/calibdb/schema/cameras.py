"""Search for cameras, and the details of one."""

from typing import Annotated

from pydantic import BeforeValidator, ConfigDict, Field

from calibdb.schema.calibration import Calibration
from calibdb.schema.fields import (
    CalibrationName,
    CameraLabel,
    Deferred,
    DistortionModel,
    ImgSize,
    Open,
    Platform,
    TrackZoom,
    UnixTime,
)
from calibdb.schema.lookup import Flag, Reason

MAX_CAMERAS = 50


def _whole(value: object) -> object:
    return int(value) if isinstance(value, str) and value.isascii() and value.isdecimal() else value


class CamerasRequest(Deferred):
    """Query of a search; unknown parameters are ignored."""

    model_config = ConfigDict(frozen=True, strict=True, extra="ignore")

    query: str = Field(
        "",
        max_length=128,
        description="Words of a name, a USB id, or a USB vendor; none: all cameras but simulated ones.",
    )
    reliable: Annotated[bool | None, Flag] = Field(
        None, description="`true`: cameras with a reliable calibration at some size; `false`: the others."
    )
    limit: Annotated[int, Field(ge=1, le=MAX_CAMERAS), BeforeValidator(_whole)] = Field(
        20, description="A page."
    )
    after: str | None = Field(
        None, max_length=256, description="`next` of the previous page of the same query."
    )


class CalibratedMode(Open):
    """Numbers of calibrations of a camera at one size and zoom."""

    img_size: ImgSize
    zoom: TrackZoom
    calibrations: int = Field(description="Calibrations that count, agreeing or not.")
    contributors: int = Field(description="Of those that agree.")
    agreeing: int = Field(description="How many calibrations agree.")
    required: int = Field(description="Number of calibrations that must agree before lookups return them.")


class CameraSize(CalibratedMode):
    """Calibrations and consensus of a camera at one size and zoom."""

    models: tuple[DistortionModel, ...] = Field(description="That were computed.")
    reliable: bool = Field(description="True if lookups return it, for at least one model.")
    fx: float | None = Field(description="px; null: no consensus yet.")
    uncertainty: float | None = Field(
        description="`uncertainty.rms` of the consensus, px; null: no consensus yet."
    )
    calibration_time: int | None = Field(description="Of the newest that agrees; Unix time, seconds.")


class NamedCamera(Open):
    """A camera by its names."""

    key: str = Field(description="Name of the camera in the database, for `GET /v1/cameras/{key}`.")
    camera: CameraLabel
    platform: Platform
    usb_id: str | None = Field(description="`vid:pid`; null: no label has one.")
    vendor: str | None = Field(description="Name of the USB vendor; null: not known.")


class CameraEntry(NamedCamera):
    """A camera that was found."""

    sizes: tuple[CameraSize, ...] = Field(description="Calibrated sizes and zooms.")


class CameraList(Open):
    """Matching cameras, and `next`. A page may have fewer than requested, even none, although more follow."""

    cameras: tuple[CameraEntry, ...] = Field(description="Matching cameras, or cameras of the rig.")
    next: str | None = Field(description="`after` of the next page; null: there is none.")


class CameraMember(Open):
    """One calibration of the camera, by the model that its session fitted; px."""

    id: CalibrationName
    time: UnixTime
    fx: float = Field(description="Focal length across, px.")
    fy: float = Field(description="Focal length down, px.")
    cx: float = Field(description="Principal point, px from the left.")
    cy: float = Field(description="Principal point, px from the top.")
    rms: float = Field(description="Root mean square, px.")
    model: str = Field(description="Distortion model of the fit.")
    in_group: bool = Field(description="It is one of those that agree.")


class CameraMode(CalibratedMode):
    """A camera at one size and zoom."""

    reason: Reason | None = Field(description="Why it is not reliable by any model; null: it is.")
    groups: tuple[tuple[str, ...], ...] = Field(description="Calibrations that agree, largest group first.")
    group_names: tuple[str | None, ...] = Field(
        description="Of each group the name of the mode that most of its contributors gave; null: none."
    )
    consensus: dict[DistortionModel, Calibration] = Field(description="By model; where there is one.")
    members: tuple[CameraMember, ...] = Field(description="The newest, last begun first.")


class CameraDetail(NamedCamera):
    """All that is known of a camera."""

    modes: tuple[CameraMode, ...] = Field(description="Calibrations and consensus by size and zoom.")
