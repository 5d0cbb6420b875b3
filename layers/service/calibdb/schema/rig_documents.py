"""Stored documents of rigs."""

from typing import Literal

from pydantic import Field

from calibdb.schema.board import Board
from calibdb.schema.calibration import BoardShape, FitRecord
from calibdb.schema.documents import EstimateDocument, Finish
from calibdb.schema.fields import Open, UnixTime, is_none
from calibdb.schema.rig import Motion, RigState, RigTarget, RigUncertainty, SetAsideReason
from calibdb.schema.session import SetAside


class MemberDocument(Open):
    """Session of one camera."""

    session: str
    contributor: str
    joined: int  # unix seconds


class MomentDocument(Open):
    """Opened moment; an undone one is never opened again."""

    id: str
    opened: int  # unix seconds
    undone: bool = False


class SkipsDocument(Open):
    """Skipped targets, and the digest of the views after which they were shown."""

    basis: str
    poses: tuple[Motion, ...] = ()
    missed: int = 0  # number of those without a pose, since the rig was not known yet


class CodeDocument(Open):
    """Keyed hash of a join code."""

    digest: str
    until: int  # unix seconds


class EndingDocument(Open):
    """End of one camera's session, fixed when the rig ends."""

    session: str
    estimate: EstimateDocument
    finish: Finish
    views: tuple[tuple[int, float | None, SetAside | None], ...]  # index, px rms, why it is set aside


class RigCalibrationDocument(Open):
    """Finished rig: `rig_calibrations/<id>.json`. Never overwritten."""

    layout: Literal[1] = 1
    id: str
    time: UnixTime
    solver: str
    contributors: tuple[str, ...]  # by position
    state: RigState


class RigFinish(Open):
    """Outcome fixed when the rig was finished."""

    calibration: RigCalibrationDocument
    endings: tuple[EndingDocument, ...]


class RigDocument(Open):
    """Running rig without its views, which its sessions have: `rigs/<id>/<version>.json`."""

    layout: Literal[1] = 1
    rig: str
    started: int  # unix seconds
    board: Board
    square_size: float | None = None
    members: tuple[MemberDocument | None, ...]  # by position
    moments: tuple[MomentDocument, ...] = ()
    skips: SkipsDocument | None = None
    codes: tuple[CodeDocument, ...] = ()  # oldest first
    finish: RigFinish | None = None

    @property
    def leader(self) -> str:
        """Session of camera 0."""
        first = self.members[0]
        return first.session if first else ""


class TurnedView(Open):
    """View with corners numbered from another side of the board."""

    moment: str
    position: int


class ViewSetAside(TurnedView):
    """View that the joint fit leaves out."""

    reason: SetAsideReason


class BoardPose(Open):
    """Pose of the board in a moment, board -> camera 0."""

    moment: str
    pose: Motion


class RigFit(Open):
    """Joint fit of all cameras, lengths in squares."""

    cameras: tuple[FitRecord, ...]
    poses: tuple[Motion, ...]  # camera 0 -> camera i
    std: tuple[Motion, ...]
    rms: float
    uncertainty: RigUncertainty
    held_out_rms: float | None = None
    set_aside: tuple[ViewSetAside, ...] = ()
    turned: tuple[TurnedView, ...] = ()
    board_poses: tuple[BoardPose, ...] = ()
    board_shape: BoardShape | None = Field(None, exclude_if=is_none)


class RigEstimateDocument(Open):
    """Fit and target computed from some views: `rigs/<id>/state/<digest>.json`."""

    layout: Literal[1] = 1
    fit: RigFit | None = None
    problem: str | None = None  # why there is no fit
    too_slow: bool = False  # it takes longer to compute than a request may
    unlinked: tuple[int, ...] = ()
    target: RigTarget | None = None
    target_pose: Motion | None = None  # board -> camera 0
