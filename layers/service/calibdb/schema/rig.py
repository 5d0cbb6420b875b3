"""Rigs of cameras that do not move against each other: requests and responses."""

from typing import Annotated, Literal, get_args

from pydantic import Field

from calibdb.schema.board import DescribedBoard
from calibdb.schema.calibration import BoardShape, Calibration
from calibdb.schema.fields import (
    CalibrationName,
    Detail,
    DistortionModel,
    ImgSize,
    Open,
    Row,
    Strict,
    Whole,
    is_none,
)
from calibdb.schema.membership import MAX_RIG_CAMERAS, MIN_RIG_CAMERAS, MomentId
from calibdb.schema.session import HintName, Remark, TargetView

RigUnit = Literal["squares", "metres"]
RigVerdictReason = Literal["uncertain", "held_out", "set_aside"]
RigFormat = Literal["json", "opencv_stereo", "ros", "kalibr", "colmap", "mrcal", "gltf"]
RIG_FORMATS: tuple[str, ...] = get_args(RigFormat)
SetAsideReason = Literal["outlier", "mirrored", "degenerate", "contradicts"]
Motion = Annotated[
    tuple[float, float, float, float, float, float],
    Field(description="Rotation vector, rad, and translation."),
]


class RigRequest(Strict):
    """Makes a rig whose first camera is that of the session."""

    cameras: Annotated[int, Field(strict=True, ge=MIN_RIG_CAMERAS, le=MAX_RIG_CAMERAS), Whole] = Field(
        description="Number of cameras."
    )
    square_size: float | None = Field(
        None,
        ge=1e-4,
        le=10,
        description="Side of a square (of an AprilGrid: of a tag), metres; without, lengths are in squares.",
    )


class RigOpened(Open):
    """A rig, and the code by which other cameras join it."""

    rig_id: str
    join_code: str = Field(description="Six characters, without those that look alike.")
    expires_at: int = Field(description="Unix time at which the code expires, seconds.")


class MomentRequest(Strict):
    """Opens a moment: from now on cameras may send their views of it."""

    moment: MomentId


class RigCamera(Open):
    """One camera of the rig."""

    position: int
    camera: str | None = Field(description="Label of the camera; null until a camera has joined.")
    img_size: ImgSize | None
    distortion_model: DistortionModel | None = Field(
        description="Model of the lens; its name gives the order of the coefficients."
    )
    status: Literal["waiting", "capturing", "finished"] = Field(
        description="`waiting`, `capturing` or `finished`."
    )
    views: int = Field(description="Views of moments that count.")


class MomentSetAside(Open):
    """View of a moment that takes no part in the fit."""

    position: int
    reason: SetAsideReason = Field(description="Reason, for programs.")
    detail: Detail


class LatestMoment(Open):
    """The moment that was opened last."""

    id: CalibrationName
    positions: tuple[int, ...] = Field(description="Positions of the cameras that have sent a view of it.")


class RigMoment(LatestMoment):
    """One moment, and what of it is set aside."""

    set_aside: tuple[MomentSetAside, ...] = Field(
        (), description="Reason why the view no longer counts; null: it counts."
    )


class RigUncertainty(Open):
    """Predicted error of the rig."""

    rotation_deg: float = Field(description="Expected turn of the camera that is known worst, degrees.")
    translation_percent: float = Field(
        description="Expected shift of the camera that is known worst / its distance from camera 0, per cent."
    )
    rms: float = Field(
        description="Distance between points of one camera, at working distance, and where the rig projects "
        "them in another, px rms."
    )


class RigTargetView(TargetView):
    """The target as one camera of a rig would see it; pixels of its `img_size`, distortion included."""

    position: int


class RigTarget(Open):
    """Target pose of the board, as each camera would see it."""

    purpose: str
    hint: str
    hint_code: HintName
    cameras: tuple[RigTargetView, ...] = Field(description="Cameras that are absent would not see it.")


class RigAdvice(Remark):
    """Something that those who capture should know of the rig."""

    code: Literal[
        "waiting", "unlinked", "no_fit", "contradicts", "set_aside", "turned", "too_few_views", "converged"
    ] = Field(description="Identifier for programs.")
    positions: tuple[int, ...] = ()


class Extrinsics(Open):
    """Pose of one camera: x -> R x + t from camera 0 to it."""

    position: int
    rvec: Row
    tvec: Row
    std: Motion = Field(description="Standard deviations of rvec (rad) and tvec.")


class MomentPose(Open):
    """Pose of the board in one moment, board -> camera 0."""

    moment: str
    rvec: Row
    tvec: Row


class RigVerdict(Open):
    """Verdict about a finished rig."""

    level: Literal["good", "fair", "poor"]
    reasons: tuple[RigVerdictReason, ...] = Field(
        (),
        description="`uncertain`: the predicted error is larger than the one aimed at; `held_out`: moments "
        "left out of the fit contradict it; `set_aside`: many views were left out.",
    )


class RigResult(Open):
    """Cameras of a rig, and where they are."""

    rig_id: str
    cameras: tuple[str, ...] = Field(description="Ids of the cameras' own calibrations, by position.")
    calibrations: tuple[Calibration, ...] = Field(description="The cameras as they were fitted together.")
    extrinsics: tuple[Extrinsics, ...]
    unit: RigUnit = Field(description="Unit of tvec.")
    rms: float = Field(description="rms over all measurements but those of views set aside, px")
    held_out_rms: float | None = Field(
        None, description="rms px of moments under a rig that was fitted without them; null: too few moments."
    )
    uncertainty: RigUncertainty
    verdict: RigVerdict
    board_poses: tuple[MomentPose, ...] = Field((), description="Boards of the moments that count.")
    board_shape: BoardShape | None = Field(
        None, exclude_if=is_none, description="Shape of the board in the fit; missing: as drawn."
    )


class RigState(Open):
    """Progress of the rig."""

    rig_id: str
    status: Literal["capturing", "finished"] = Field(description="`capturing` or `finished`.")
    board: DescribedBoard
    square_size: float | None
    unit: RigUnit
    cameras: tuple[RigCamera, ...] = Field(description="Matching cameras, or cameras of the rig.")
    moment: LatestMoment | None
    moments: tuple[RigMoment, ...]
    uncertainty: RigUncertainty | None = Field(description="null before the first fit.")
    target_error: float = Field(description="px; the `uncertainty.rms` at which the rig has converged.")
    progress: float = Field(ge=0, le=1, description="Progress, 0 to 1.")
    unlinked: tuple[int, ...] = Field(
        description="Positions of the cameras that share no moment with camera 0, not even by way of others."
    )
    rms: float | None = Field(description="Root mean square, px.")
    target: RigTarget | None
    advice: tuple[RigAdvice, ...] = Field(description="What to improve, most important first.")
    result: RigResult | None
