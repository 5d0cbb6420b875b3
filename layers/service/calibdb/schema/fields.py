"""Types of fields, with their bounds, and bases of models."""

import math
import threading
import unicodedata
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    JsonValue,
    StringConstraints,
    model_validator,
)
from pydantic_core import PydanticCustomError, PydanticKnownError

from calibdb.camera_key.characters import MAX_TEXT_LENGTH, visible
from calibdb.camera_key.label import MAX_MODE_NAME, public_mode_name
from calibdb.camera_key.system import with_device

MAX_CORNERS = 49 * 49  # of the largest board
MIN_IMAGE_SIDE_PX, MAX_IMAGE_SIDE_PX = 16, 16384
MAX_PIXELS = 2**26  # an overlay is drawn at the size of the image
MAX_ASPECT = 8  # sides of an image: no camera's is a strip
MAX_INDEX = 100_000
MAX_LABEL = 256  # visible characters
IPV6_SOURCE = "v6-"  # beginning of a contributor's source that is an IPv6 site


building = threading.RLock()
"""Lock of the thread that builds a model, with those of its fields."""


class Deferred(BaseModel):
    """Model whose validator is built at its first use, by one thread at a time: pydantic has no lock."""

    model_config = ConfigDict(defer_build=True)

    @classmethod
    def model_rebuild(cls, *, _parent_namespace_depth: int = 2, **options: Any) -> bool | None:
        """Build validator and serializer as pydantic does."""
        depth = _parent_namespace_depth + 1  # this method's own frame
        with building:
            return super().model_rebuild(_parent_namespace_depth=depth, **options)


class Strict(Deferred):
    """Request that refuses unknown members, so that misspelt options are reported."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid", allow_inf_nan=False)


class Open(Deferred):
    """Response or stored document: fields that a later version added are ignored."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False)


def is_none(value: object) -> bool:
    """True if a member is None, which older records and clients do not know: it is left out."""
    return value is None


def _finite(value: JsonValue) -> JsonValue:
    if isinstance(value, dict):
        return {name: _finite(inner) for name, inner in value.items()}
    if isinstance(value, list):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


# JSON has no infinity: it is unknown.
Members = Annotated[dict[str, JsonValue], AfterValidator(_finite)]


def _canonical(zoom: float) -> float:
    return round(zoom, 6) + 0.0  # + 0.0 turns -0.0 into 0.0: equal zooms are written alike


CaptureKind = Literal["live", "recorded"]

# The names, and the order of the coefficients, are the API's.
DistortionModel = Literal["rectilinear", "fisheye", "rational", "omnidirectional"]
DISTORTION_MODELS: tuple[str, ...] = get_args(DistortionModel)
Guidance = Literal["projection-uncertainty", "pose-selection"]


def _in_one_line(text: object) -> object:
    if isinstance(text, str) and len(text) > MAX_TEXT_LENGTH:  # before each character is examined
        raise PydanticKnownError("string_too_long", {"max_length": MAX_LABEL})
    return _one_spelling(text) if isinstance(text, str) else text


def _one_spelling(text: str) -> str:
    return unicodedata.normalize("NFC", visible(text))


def label_text(text: str) -> str:
    """Return foreign text, such as a name in a file, as a label; empty if none of it is visible."""
    return _one_spelling(text)[:MAX_LABEL].strip()


Label = Annotated[
    str,
    StringConstraints(strip_whitespace=True, min_length=1, max_length=MAX_LABEL),
    BeforeValidator(_in_one_line),
]


def _mode_name(text: str) -> str:
    if not (name := public_mode_name(text)):
        raise PydanticCustomError(
            "mode_name",
            "the name of a mode has at most {most} letters, digits, spaces and ° . , : + × % / -, and names "
            "no person or address",
            {"most": MAX_MODE_NAME},
        )
    return name


ModeName = Annotated[str, StringConstraints(min_length=1, max_length=MAX_LABEL), AfterValidator(_mode_name)]


def _whole(value: object) -> object:
    return int(value) if isinstance(value, float) and value.is_integer() else value


# JSON does not distinguish 1280 from 1280.0, and many programs write the latter.
Whole = BeforeValidator(_whole)
Side = Annotated[int, Field(strict=True, ge=MIN_IMAGE_SIDE_PX, le=MAX_IMAGE_SIDE_PX), Whole]


def camera_like(size: tuple[int, int]) -> tuple[int, int]:
    """Size of an image; raises PydanticCustomError if no camera has it."""
    if size[0] * size[1] > MAX_PIXELS:
        raise PydanticCustomError(
            "too_many_pixels", "the image has too many pixels; {most} are allowed", {"most": MAX_PIXELS}
        )
    if max(size) > MAX_ASPECT * min(size):
        raise PydanticCustomError(
            "strip", "one side is more than {longest} times the other", {"longest": MAX_ASPECT}
        )
    return size


ImgSize = Annotated[
    tuple[Side, Side], Field(description="Width and height, px."), AfterValidator(camera_like)
]
Zoom = Annotated[
    float,
    Field(ge=0, le=1e6, description="`zoom` of the track's settings; 0 where there is none."),
    AfterValidator(_canonical),
]
TargetError = Annotated[float, Field(ge=1e-3, le=100, description="px")]
Index = Annotated[int, Field(strict=True, ge=0, le=MAX_INDEX), Whole]
CornerId = Annotated[int, Field(strict=True, ge=0, lt=MAX_CORNERS), Whole]
Coordinate = Annotated[float, Field(ge=-1.0, le=MAX_IMAGE_SIDE_PX)]
Point = tuple[Coordinate, Coordinate]
Pixel = tuple[float, float]
Row = tuple[float, float, float]
LensModel = Annotated[
    DistortionModel, Field(description="Model of the lens; its name gives the order of the coefficients.")
]
CameraMatrix = Annotated[
    tuple[Row, Row, Row], Field(description="Row-major; pixel centres at whole numbers.")
]
Coefficients = Annotated[
    tuple[float, ...], Field(description="In the order of the model; see the conventions.")
]
CameraLabel = Annotated[str, Field(description="`MediaStreamTrack.label` of the camera.")]
Platform = Annotated[str, Field(description="The parenthesised part of the user agent.")]
CalibrationName = Annotated[
    str, Field(description="Name of the calibration or consensus, for `GET /v1/calibrations/{id}`.")
]
CornerIds = Annotated[tuple[int, ...], Field(description="Ids of the board's corners.")]
CornerPixels = Annotated[tuple[Pixel, ...], Field(description="Positions of these corners in the image, px.")]
TrackZoom = Annotated[float, Field(description="`zoom` of the track; 0 if there is none.")]
UnixTime = Annotated[int, Field(description="Unix time, seconds.")]
Detail = Annotated[str, Field(description="Explanation for people.")]


def size_text(img_size: tuple[int, int]) -> str:
    """Return `1280x720`."""
    return f"{img_size[0]}x{img_size[1]}"


def zoom_text(zoom: float) -> str:
    """Shortest writing to six decimals: `0`, `1.5`."""
    return f"{zoom:.6f}".rstrip("0").rstrip(".")


DeviceModel = Annotated[
    str,
    Field(min_length=1, max_length=64, pattern=r"^[A-Za-z0-9][\w ()+.,&-]*$"),
    BeforeValidator(_in_one_line),
]


class StreamRequest(Strict):
    """Request about one stream of a camera and the model of its lens."""

    camera: Label = Field(description="`MediaStreamTrack.label` of the camera.")
    platform: Label = Field(description="The parenthesised part of the user agent.")
    device: DeviceModel | None = Field(
        None,
        description="Model identifier of the phone, `iPhone17,3`, if label and platform do not name the "
        "model. It becomes a part of `platform`, and so of the camera's key.",
    )
    img_size: ImgSize
    zoom: Zoom = 0.0
    distortion_model: LensModel = "rectilinear"

    @model_validator(mode="after")
    def _join_device(self) -> Self:
        """Make `device` a part of `platform`."""
        if self.device is not None:
            joined = with_device(self.platform, self.device)
            if len(joined) <= MAX_LABEL:
                object.__setattr__(self, "platform", joined)  # the model is frozen from here on
        return self


CROPPED = "crop-and-scale"  # the `resizeMode` that cuts the image


class StreamKey(StreamRequest):
    """Request by the key of a camera."""

    resize_mode: str | None = Field(
        None,
        max_length=64,
        description="`resizeMode` of the track: a stream that the browser crops is another picture.",
    )
