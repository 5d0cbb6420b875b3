"""Request of a lookup, and its responses without a calibration."""

import re
from typing import Annotated, Literal
from urllib.parse import urlencode

from pydantic import AliasChoices, BeforeValidator, ConfigDict, Field

from calibdb.schema.board import Board, DescribedBoard
from calibdb.schema.estimate import Estimate
from calibdb.schema.fields import (
    Detail,
    ImgSize,
    Label,
    Open,
    StreamKey,
    Zoom,
    size_text,
    zoom_text,
)
from calibdb.schema.observed_corners import MAX_VIEWS, ObservedCorners

Reason = Literal["unknown_camera", "too_few", "disagree", "few_contributors", "imprecise"]
MissReason = Annotated[Reason, Field(description="Reason, for programs.")]
GuidanceUrl = Annotated[str, Field(description="Page that calibrates the camera.")]
ESTIMATE_TEXT = "Likely camera, with its interval: never a calibration. See the document on estimates."


_SIZE = re.compile(r"([0-9]{1,6})[x×,]([0-9]{1,6})")
_NUMBER = re.compile(r"[+-]?[0-9]{1,20}(\.[0-9]{0,20})?([eE][+-]?[0-9]{1,3})?")
QUERY_FLAGS = {"true": True, "1": True, "false": False, "0": False}


# A query has text where a body has numbers. The type refuses what these cannot parse.
def _size(value: object) -> object:
    if isinstance(value, list):
        return tuple(value)
    if not isinstance(value, str):
        return value
    match = _SIZE.fullmatch(value)
    if match is None:
        raise ValueError("must be width and height, px, as in 1280x720")
    return int(match[1]), int(match[2])


def _number(value: object) -> object:
    return float(value) if isinstance(value, str) and _NUMBER.fullmatch(value) else value


def _flag(value: object) -> object:
    return QUERY_FLAGS.get(value.lower(), value) if isinstance(value, str) else value


Flag = BeforeValidator(_flag)


class Reported(Open):
    """Field of view that the device itself reports: by its operating system, or in a photo's EXIF data."""

    focal_35mm: Annotated[float, Field(gt=3, le=2000)] | None = Field(
        None, description="Focal length equivalent to that on 35 mm film, mm (`FocalLengthIn35mmFilm`)."
    )
    hfov_deg: Annotated[float, Field(gt=1, lt=179)] | None = Field(
        None, description="Horizontal field of view at this size, degrees."
    )
    dfov_deg: Annotated[float, Field(gt=1, lt=179)] | None = Field(
        None, description="Diagonal field of view at this size, degrees."
    )


class LookupRequest(StreamKey):
    """Camera key, by the paper's names or by those of the older public client.

    Unknown fields are ignored: clients of every age ask here.
    """

    model_config = ConfigDict(extra="ignore")

    platform: Label = Field(
        validation_alias=AliasChoices("platform", "userAgent"),
        description="The parenthesised part of the user agent.",
    )
    img_size: Annotated[ImgSize, BeforeValidator(_size)] = Field(
        validation_alias=AliasChoices("img_size", "imsize")
    )
    zoom: Annotated[Zoom, BeforeValidator(_number)] = 0.0
    resize_mode: str | None = Field(
        None,
        max_length=64,
        validation_alias=AliasChoices("resize_mode", "resizeMode"),
        description="`resizeMode` of the track: a stream that the browser crops is another picture.",
    )
    reported: Reported | None = Field(
        None, description="A field of view that the device reports. Only the estimate uses it."
    )
    board: DescribedBoard = Board()
    views: tuple[ObservedCorners, ...] = Field(
        (),
        max_length=MAX_VIEWS,
        description="Frames of the board, tilted differently. If the calibrations of the camera fall into "
        "groups, the estimate is the group that fits. Not in a query.",
    )
    redirect: Annotated[bool, Flag] = Field(
        True, description="`false`: 404 with `guidance_url` instead of a redirect."
    )
    estimate: Literal["always"] | None = Field(
        None,
        description="`always`: a calibration comes with an `estimate`, too: that of the camera if the "
        "database had no calibration of it.",
    )
    miss: Literal["ok"] | None = Field(
        None, description="`ok`: a miss returns 200 with `calibration: null` instead of 307 or 404."
    )

    @property
    def key_query(self) -> str:
        """Query of the page that calibrates this camera."""
        return urlencode(
            {
                "camera": self.camera,
                "platform": self.platform,
                "img_size": size_text(self.img_size),
                "zoom": zoom_text(self.zoom),
                "distortion_model": self.distortion_model,
            }
        )


class UnknownCamera(Open):
    """Reason why `GET /known/v1/…` has no answer; the body of its 404."""

    reason: MissReason


class Miss(Open):
    """Address of the guidance page, and the reason for the miss; the body of the 307."""

    guidance_url: GuidanceUrl
    reason: MissReason
    detail: Detail
    estimate: Estimate | None = Field(None, description=ESTIMATE_TEXT)


class NoCalibration(Miss):
    """Answer with 200 where nothing reliable is known (`miss: "ok"`)."""

    calibration: None = Field(
        None, description="The calibration; null: none yet, or nothing reliable is known."
    )
