"""The guided capture: requests and responses."""

from typing import Annotated, Literal

from pydantic import Field

from calibdb.schema.board import Board, DescribedBoard
from calibdb.schema.calibration import BoardShape, Calibration, Uncertainty
from calibdb.schema.fields import (
    CameraLabel,
    CaptureKind,
    CornerIds,
    CornerPixels,
    Detail,
    DistortionModel,
    Guidance,
    ImgSize,
    Index,
    LensModel,
    ModeName,
    Open,
    Pixel,
    Platform,
    Row,
    StreamRequest,
    Strict,
    TargetError,
    TrackZoom,
    UnixTime,
    is_none,
)
from calibdb.schema.licence import Licence, Licensed
from calibdb.schema.membership import MomentId, RigJoin, RigMembership
from calibdb.schema.observed_corners import ObservedCorners

MAX_RECORDED_VIEWS = 200  # of a recorded session; a live one ends long before
_REPORTED = Field(description="As the track reports it.")
Fact = Annotated[Annotated[str, Field(max_length=64)] | None, _REPORTED]
Quantity = Annotated[Annotated[float, Field(ge=-1e9, le=1e9)] | None, _REPORTED]
Refusal = Literal["too_few_points", "degenerate", "mirrored", "outlier", "duplicate", "no_information"]
End = Literal["target", "plateau", "limit", "nothing_new", "asked"]


HintCode = Literal[
    "first",
    "closer",
    "farther",
    "left",
    "right",
    "up",
    "down",
    "tilt_top",
    "tilt_bottom",
    "tilt_left",
    "tilt_right",
    "turn_clockwise",
    "turn_counterclockwise",
    "show_more",
    "hold_still",
    "unmirror",
]


HintName = Annotated[HintCode, Field(description="The next movement, for programs.")]


class Health(Open):
    """The service is there."""

    status: Literal["ok"] = Field("ok", description="`ok`.")


class SessionOpened(Open):
    """The credential of one guided capture."""

    session_id: str = Field(description="Credential of the session's calls.")
    expires_at: UnixTime


class Track(Open):
    """Further settings of the MediaStreamTrack: stored, never part of the camera's key.

    A page may send all settings of the track; what is not listed here, such as ids of devices, is not kept.
    """

    focusMode: Fact = None  # noqa: N815 - names of the MediaStreamTrack's settings
    focusDistance: Quantity = None  # noqa: N815
    facingMode: Fact = None  # noqa: N815
    resizeMode: Fact = Field(  # noqa: N815
        None, description="As the track reports it. Cropped streams have different intrinsics."
    )
    frameRate: Quantity = None  # noqa: N815


class LicenceRequest(Strict, Licensed):
    """Gives the views of a session away."""

    licence: Licence = Field(description="The contributor agrees that the views may be given away.")


class SessionRequest(StreamRequest, Licensed):
    """Starts a guided capture of one camera."""

    board: DescribedBoard = Board()
    guidance: Guidance = Field("projection-uncertainty", description="How the next pose is chosen.")
    target_error: TargetError | None = Field(
        None, description="px over the image at which the session ends; default 0.3 at 1280 px image width."
    )
    track: Track = Field(
        Track(), description="Facts about the `MediaStreamTrack`. Stored, never part of the key."
    )
    capture: CaptureKind = Field(
        "live",
        description="`recorded`: the views are all there already (photographs, a video, corners that another "
        "program found). Every view that agrees with the others is accepted, whatever it adds, and "
        "`POST /v1/session/finish` ends the session.",
    )
    rig: RigJoin | None = Field(
        None, description="The rig that this camera joins; then the rig ends the session."
    )
    mode_name: ModeName | None = Field(
        None,
        description="Public name of the camera's mode, such as `stabilisation on`. If the calibrations of "
        "the camera fall into groups, a group has the name that most of its contributors gave.",
    )


class ViewRequest(ObservedCorners):
    """One captured frame: the board corners seen, and the pose that it answers."""

    index: Index | None = Field(
        None, description="Index of the pose that it answers; needed unless it has a `moment`."
    )
    moment: MomentId | None = Field(
        None, description="The moment that it shows: required of a session that is in a rig, and of no other."
    )


class BatchRequest(Strict):
    """Several frames of a recorded session."""

    index: Index = Field(
        description="Index that the first accepted view takes: 0, later one more than that of the last "
        "accepted view. The same request again returns the same indices."
    )
    views: tuple[ObservedCorners, ...] = Field(
        min_length=1,
        max_length=MAX_RECORDED_VIEWS,
        description="Frames in the order in which they are judged.",
    )


class SetAside(Open):
    """Reason for which an accepted view is excluded from the fit."""

    reason: Literal["outlier", "disagrees", "degenerate"] = Field(
        description="`outlier`: found wrong once others were there; `disagrees`: more views contradict it; "
        "`degenerate`: its corners lie on a line (of imported views)."
    )
    detail: Detail


class ViewState(Open):
    """One accepted view."""

    index: int = Field(description="Index of the view.")
    points: int = Field(description="Number of points.")
    rms: float | None = Field(
        description="px; null as long as there is no fit. Of a view set aside: with only its pose fitted."
    )
    set_aside: SetAside | None = Field(
        None, description="Reason why the view no longer counts; null: it counts."
    )
    on_target: bool | None = Field(
        None, description="true: the board was held at the target. null: there was no target."
    )


class Remark(Open):
    """Something for people."""

    text: str = Field(description="Text for people.")


class Advice(Remark):
    """Something the user should know of the whole capture."""

    code: Literal[
        "prediction_disagrees",
        "limit_reached",
        "model_too_simple",
        "board_bent",
        "motion",
        "focus_changed",
    ] = Field(description="Identifier for programs.")


class Hint(Open):
    """Hint that leads to the next view."""

    code: HintCode = Field(description="Identifier for programs.")
    text: str = Field(description="English, at most six words.")


class VerdictReason(Remark):
    """Reason why a calibration is not good: a code for programs, a sentence for people."""

    code: str = Field(description="Identifier for programs.")


class Verdict(Open):
    """Verdict on a calibration by its predicted errors."""

    level: Literal["good", "fair", "poor"]
    reasons: tuple[VerdictReason, ...] = Field(description="The one to act on first; none if it is good.")


class SessionState(Open, Licensed):
    """Progress of the capture."""

    status: Literal["capturing", "converged"] = Field(description="`capturing` or `converged`.")
    camera: CameraLabel
    platform: Platform
    img_size: ImgSize
    zoom: TrackZoom
    distortion_model: LensModel
    board: DescribedBoard
    guidance: Guidance = Field(description="How the next pose is chosen.")
    target_error: float = Field(description="Predicted error at which the session ends, px.")
    capture: CaptureKind = Field(
        "live", description="`live`: views arrive one by one; `recorded`: all views exist already."
    )
    rig: RigMembership | None = Field(None, description="The rig that the session is in; null: none.")
    views: tuple[ViewState, ...] = Field(description="The views of the session.")
    progress: float = Field(ge=0, le=1, description="Progress, 0 to 1.")
    uncertainty: Uncertainty | None = Field(
        description="Predicted error of a projection over the image, px; null before the first fit."
    )
    systematic: float | None = Field(None, description="As in `calibration`; null: there is no fit yet.")
    board_shape: BoardShape | None = Field(
        None,
        exclude_if=is_none,
        description="Shape of the board in the fit so far; missing: as drawn, or before the first fit.",
    )
    calibration: Calibration | None = Field(
        description="The calibration; null: none yet, or nothing reliable is known."
    )
    calibration_id: str | None = Field(
        description="Name of the published calibration; null before the session's end."
    )
    end: End | None = Field(
        None,
        description="Reason why the capture ended. `target`: the target error is reached. `plateau`: the "
        "error has stopped falling. `limit`: fifteen views are in. `nothing_new`: six duplicates in a row. "
        "`asked`: the user ended it. null: it has not ended.",
    )
    verdict: Verdict | None = Field(None, description="Verdict on the result; null: there is none yet.")
    advice: tuple[Advice, ...] = Field((), description="What to improve, most important first.")
    suggested_model: DistortionModel | None = Field(
        None, description="The model that explains these views better, where this one is too simple."
    )


class ViewAnswer(SessionState):
    """The session's state, and whether the view became part of it."""

    accepted: bool = Field(description="True if the view became part of the session.")
    reason: Refusal | None = Field(description="Reason, for programs.")
    hint: Hint | None = Field(None, description="What to do after a refusal.")


class BatchResult(Open):
    """Result of one view of a batch."""

    accepted: bool = Field(description="True if the view became part of the session.")
    index: int | None = Field(description="Index of the view in the session; null: it was refused.")
    reason: Refusal | None = Field(description="Reason of a refusal.")
    error: float | None = Field(
        description="px, predicted rms projection error over the image with this view; null: it was refused, "
        "or there is no fit yet."
    )


class BatchAnswer(SessionState):
    """The session's state, and the results of the views of a batch."""

    results: tuple[BatchResult, ...] = Field(
        description="In the order of the views. If there are fewer, the request's time was used up. Send the "
        "other views in another request."
    )


class TargetView(Open):
    """Target as one camera would see it; pixels of its `img_size`, distortion included."""

    rvec: Row = Field(description="Rotation vector, board to camera, rad.")
    tvec: Row = Field(description="Translation, squares.")
    ids: CornerIds
    corners: CornerPixels
    outline: tuple[Pixel, ...] = Field(description="The board's edge as the camera would see it.")
    hint: str = Field(description="What to do next, in English, at most six words; sides are the picture's.")
    hint_code: HintName


class Pose(TargetView):
    """Target pose of the board; pixels of `img_size`, distortion included."""

    index: int = Field(description="The index that a view answering this pose carries.")
    purpose: str = Field(description="What this view is for, in English.")
