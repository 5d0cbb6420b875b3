"""Stored documents. `layout` is the version of their format."""

from typing import Literal

from pydantic import Field

from calibdb.camera_key import current_key
from calibdb.schema.board import Board
from calibdb.schema.calibration import Calibration, FitRecord, Uncertainty
from calibdb.schema.fields import (
    CaptureKind,
    DistortionModel,
    Guidance,
    ImgSize,
    Members,
    Open,
    Pixel,
    UnixTime,
    is_none,
)
from calibdb.schema.licence import Licensed
from calibdb.schema.lookup import Reason
from calibdb.schema.membership import RigMembership
from calibdb.schema.session import Advice, End, SetAside, Track


class ViewDocument(Open):
    """One accepted view. `rms` is its residual in the latest fit, px."""

    index: int
    ids: tuple[int, ...]
    points: tuple[Pixel, ...]
    rms: float | None = None
    set_aside: SetAside | None = None
    on_target: bool | None = Field(None, exclude_if=is_none)  # held at its target
    stated: float | None = Field(None, exclude_if=is_none)  # px, expected rms error after it
    moment: str | None = Field(None, exclude_if=is_none)  # of a rig


class EstimateDocument(Open):
    """Estimate from the views of a session."""

    fit: FitRecord | None = None
    uncertainty: Uncertainty | None = None
    progress: float = 0.0
    converged: bool = False
    end: End | None = Field(None, exclude_if=is_none)
    advice: tuple[Advice, ...] = ()
    suggested_model: DistortionModel | None = None
    time: int = 0  # unix seconds at which it was made


class Finish(Open):
    """Outcome fixed when the session converged: publishing it needs only the document."""

    calibration_id: str
    time: int  # unix seconds
    contributor: str
    source: str | None = None  # hash of where the contributor is; older ends have none
    solver: str
    report: Members | None = None


class CameraDocument(Open, Licensed):
    """Camera whose views a contributor gave, and the board that they show."""

    layout: Literal[1] = 1
    camera_key: str
    camera: str
    platform: str
    img_size: ImgSize
    zoom: float
    board: Board
    contributor: str | None = None
    source: str | None = None  # hash of where the contributor is

    @property
    def current_key(self) -> str:
        """Key of the camera by today's rules."""
        return current_key(self.camera_key, self.camera, self.platform)

    def calibrated(self, fit: FitRecord, name: str | None, time: int) -> Calibration:
        """Calibration of the camera by one fit; `name`: its id."""
        return Calibration.of(
            fit,
            id=name,
            camera=self.camera,
            platform=self.platform,
            zoom=self.zoom,
            calibration_time=time,
        )


class GivenDocument(CameraDocument):
    """Document that counts once per contributor."""

    id: str
    contributor: str
    time: UnixTime

    @property
    def counted_as(self) -> str:
        """Identity by which contributors are counted."""
        return self.source or self.contributor


class CaptureDocument(CameraDocument):
    """Camera, board and options of a session, as it was started."""

    distortion_model: DistortionModel
    guidance: Guidance
    target_error: float
    track: Track
    capture: CaptureKind = "live"
    rig: RigMembership | None = Field(None, exclude_if=is_none)
    mode_name: str | None = Field(None, exclude_if=is_none)  # that the contributor gave to the camera's mode


class SessionDocument(CaptureDocument):
    """All of a running session: `sessions/<sid>/<version>.json`."""

    session: str
    first_version: int = 1  # differs between a session and a restarted one with the same id
    started: int  # unix seconds
    contributor: str | None = None  # hash of who started it; None in old ones
    next_index: int = 0
    views: tuple[ViewDocument, ...] = ()
    target: Members | None = None
    skipped: tuple[Members, ...] = ()  # targets not wanted since the last view
    unreached: tuple[Members, ...] = ()  # targets given up before earlier views
    duplicates: int = 0  # refused since the last accepted view
    doubted: tuple[ViewDocument, ...] = ()  # outliers, kept since the other views may be wrong
    prior: FitRecord | None = None  # start of the first estimate: calibration of this camera by others
    estimate: EstimateDocument = EstimateDocument()
    finish: Finish | None = None


class CalibrationDocument(GivenDocument, CaptureDocument):
    """All of a finished session: `calibrations/<camera key>/<id>.json`. Only a licence is ever added."""

    views: tuple[ViewDocument, ...]
    set_aside: tuple[ViewDocument, ...] = ()  # captured too, and found not to belong to the others
    fits: dict[DistortionModel, FitRecord]
    report: Members | None = None  # `calibsolver.quality.report.describe` of the fit
    solver: str

    def answer(self) -> Calibration:
        """Calibration of the session's own model, as the API returns it."""
        return self.calibrated(self.fits[self.distortion_model], self.id, self.time)


class Votes(Open):
    """Numbers of contributors whose own views fit a consensus, and did not."""

    agree: int = Field(0, description="Checks that agree with the consensus.")
    disagree: int = Field(0, description="Checks that contradict the consensus.")


class ShapeDocument(Open):
    """Shape of a board, by the names of `calibsolver`'s `BoardShape`."""

    center: Pixel
    half: float = Field(gt=0)
    reach: Pixel
    parameters: tuple[float, float, float, float, float]


class VoteDocument(GivenDocument):
    """One check that counts: `votes/<camera key>/<id>.json`. Never overwritten.

    It keeps the views, not the verdict: they are scored again whenever the consensus changes, so that no
    consensus inherits the verdict on another.
    """

    views: tuple[ViewDocument, ...]
    noise: float  # px rms of the views under a camera of their own: what no camera can do better
    fit: FitRecord | None = None  # that camera, by the model that was checked; votes of old have none
    board_shape: ShapeDocument | None = Field(None, exclude_if=is_none)  # that `noise` and `fit` refer to


class ConsensusDocument(Open):
    """Consensus of all calibrations of one camera at one size and zoom, for one model.

    `basis` is a digest of all inputs: the calibrations that count, the votes, the thresholds, the solver.
    `pooled` is the same without the votes.
    """

    layout: Literal[1] = 1
    camera_key: str
    img_size: ImgSize
    zoom: float
    distortion_model: DistortionModel
    total: int  # calibrations considered
    latest: int  # unix seconds, of the newest of these
    basis: str = ""
    pooled: str = ""
    found: Reason | None = None  # why its calibrations do not make it reliable
    confirmable: bool = False  # the missing number of agreeing calibrations would make it reliable
    votes: Votes = Votes()
    reason: Reason | None = None  # why it is not reliable
    calibration: Calibration | None = None

    @property
    def reliable(self) -> bool:
        """True if lookups may return it."""
        return self.calibration is not None and self.calibration.reliable


class GroupsDocument(Open):
    """Details of the calibrations behind a consensus, for camera pages."""

    layout: Literal[1] = 1
    pooled: str  # of the consensus that it belongs to
    groups: tuple[tuple[str, ...], ...] = ()  # ids of calibrations that agree, largest group first
    errors: dict[str, float] = Field({})  # px; of each calibration's views under a fit without it
    covariance: tuple[tuple[float, ...], ...] | None = None  # of the consensus; None: made before it was kept


class PriorDocument(Open):
    """First guess for a capture, from another source: `priors/<camera key>/<w>x<h>~<zoom>~<model>.json`."""

    layout: Literal[1] = 1
    camera_key: str
    camera: str
    platform: str
    zoom: float
    fit: FitRecord
    source: str
    measured: int  # number of that source's calibrations that it stands for
