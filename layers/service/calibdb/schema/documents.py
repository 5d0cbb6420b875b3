"""What is stored. Every document says the version of its layout, so that later code can read earlier data."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, JsonValue

from calibdb.schema.board import Board
from calibdb.schema.calibration import Calibration, FitRecord, Uncertainty
from calibdb.schema.fields import DistortionModel, Guidance, ImgSize, Open, Pixel
from calibdb.schema.lookup import Reason
from calibdb.schema.session import Track


class ViewDocument(Open):
    """One accepted view. `rms` is its residual in the latest fit, px."""

    index: int
    ids: tuple[int, ...]
    points: tuple[Pixel, ...]
    rms: float | None = None


class EstimateDocument(Open):
    """What the views so far give."""

    fit: FitRecord | None = None
    uncertainty: Uncertainty | None = None
    progress: float = 0.0
    converged: bool = False
    time: int = 0  # unix seconds at which it was made


class Finish(Open):
    """What was fixed when the session converged. Publishing it follows from the document alone."""

    calibration_id: str
    time: int  # unix seconds
    contributor: str
    solver: str


class CaptureDocument(Open):
    """What was captured with what, as a session was started."""

    layout: Literal[1] = 1
    camera_key: str
    camera: str
    platform: str
    img_size: ImgSize
    zoom: float
    distortion_model: DistortionModel
    board: Board
    guidance: Guidance
    target_error: float
    track: Track


class SessionDocument(CaptureDocument):
    """All of a running session: `sessions/<sid>/<version>.json`."""

    session: str
    first_version: int = 1  # differs between a session and the one started anew under its id
    started: int  # unix seconds
    next_index: int = 0
    views: tuple[ViewDocument, ...] = ()
    target: dict[str, JsonValue] | None = None
    skipped: tuple[dict[str, JsonValue], ...] = ()
    estimate: EstimateDocument = EstimateDocument()
    finish: Finish | None = None


class CalibrationDocument(CaptureDocument):
    """All of a finished session: `calibrations/<camera key>/<id>.json`. Never overwritten."""

    id: str
    views: tuple[ViewDocument, ...]
    fits: dict[DistortionModel, FitRecord]
    solver: str
    contributor: str
    time: int = Field(description="Unix time, seconds.")

    def answer(self) -> Calibration:
        """Return the calibration of the session's own model, as the API answers it."""
        return Calibration.of(
            self.fits[self.distortion_model],
            id=self.id,
            camera=self.camera,
            platform=self.platform,
            zoom=self.zoom,
            calibration_time=self.time,
        )


class ConsensusDocument(Open):
    """What all calibrations of one camera at one size and zoom agree on, for one model.

    `total` and `latest` say how many calibrations were considered: an older computation never replaces a
    newer. `basis` stands for which they were, and by which rule they were pooled: equal, nothing is new.
    """

    layout: Literal[1] = 1
    camera_key: str
    img_size: ImgSize
    zoom: float
    distortion_model: DistortionModel
    total: int
    latest: int  # unix seconds
    basis: str = ""
    reason: Reason | None = None  # why it is not reliable
    calibration: Calibration | None = None  # None: nothing believable came out

    @property
    def reliable(self) -> bool:
        """Tell whether a lookup may answer with it."""
        return self.calibration is not None and self.calibration.reliable
