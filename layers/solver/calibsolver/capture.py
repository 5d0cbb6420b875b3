"""The rules of one guided capture."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from . import models, normal, start
from .arrays import Array
from .board import Board
from .calibration import Calibration
from .camera import Camera
from .errors import CalibrationError
from .fit import MIN_POINTS, check, fit
from .guidance import LEAST_NOISE, Belief, ProjectionUncertainty
from .observations import Observations
from .target import TargetPose
from .uncertainty import Uncertainty
from .view import View

Reason = Literal["too_few_points", "degenerate", "mirrored", "outlier", "no_information"]

MIN_VIEWS = 4
"""Fewer views can agree by chance."""
LEAST_SHARE = 0.2
"""Of the gain predicted for the target that a view must bring."""
OUTLIER = 3.0
"""Times the others' rms from which a view is one that does not belong."""
GUIDANCE = {"projection-uncertainty": ProjectionUncertainty}


@dataclass(frozen=True, eq=False)
class Estimate:
    """What is known after some views.

    Attributes
    ----------
    calibration
        None while no believable fit exists.
    view_errors
        px rms of each view, None without a calibration.
    uncertainty
        Predicted error of a projection over the image, px.
    progress
        0 to 1; 1 where converged. It follows the predicted error and the number of views, so it grows with
        every view that brings information; it may fall with one that shows more noise than was seen before.
    converged
        Whether the predicted rms is below the target and at least four views are in.
    """

    calibration: Calibration | None
    view_errors: tuple[float | None, ...]
    uncertainty: Uncertainty | None
    progress: float
    converged: bool


@dataclass(frozen=True, eq=False)
class Verdict:
    """Whether a view is taken; if not, why; if so, the estimate with it."""

    accepted: bool
    reason: Reason | None
    estimate: Estimate | None


class Capture:
    """One guided capture: everything but its state, which is the list of views.

    Parameters
    ----------
    board, img_size, model
        What is captured with what; width and height in px.
    guidance
        ``projection-uncertainty``.
    target_error
        px, predicted rms projection error over the image at which the capture ends.
    """

    def __init__(
        self,
        board: Board,
        img_size: tuple[int, int],
        model: str = "rectilinear",
        guidance: str = "projection-uncertainty",
        target_error: float = 0.3,
    ) -> None:
        if guidance not in GUIDANCE:
            raise ValueError(f"unknown guidance {guidance!r}")
        self.board = board
        self.img_size = (int(img_size[0]), int(img_size[1]))
        self.model = models.get(model).name
        self.target_error = float(target_error)
        self.guide = GUIDANCE[guidance](board, self.img_size, model)
        belief = Belief.of(self.model, self.img_size, None)
        # One view brings the prior down to some px; before it there is nothing to show.
        self._unknown = 0.03 * self.img_size[0]
        self._prior_camera = belief.camera

    def camera(self, estimate: Estimate | None) -> Camera:
        """Return the camera to draw with: the estimate's, or the prior's where there is none."""
        if estimate is None or estimate.calibration is None:
            return self._prior_camera
        return estimate.calibration.camera

    def estimate(self, views: Sequence[View]) -> Estimate:
        """Fit all views anew. Where that fails the estimate has no calibration; nothing is raised."""
        if not views:
            return Estimate(None, (), None, 0.0, False)
        try:
            calibration = fit(views, self.img_size, self.model)
        except CalibrationError:
            return Estimate(None, (None,) * len(views), None, 0.0, False)
        u = self._uncertainty(calibration)
        converged = u.rms < self.target_error and len(views) >= MIN_VIEWS
        span = np.log(self._unknown / self.target_error)
        sure = float(np.clip(np.log(self._unknown / max(u.rms, 1e-9)) / span, 0, 1)) if span > 0 else 1.0
        progress = 1.0 if converged else min(0.95 * sure, len(views) / MIN_VIEWS, 0.95)
        return Estimate(calibration, tuple(calibration.view_errors.tolist()), u, progress, converged)

    def _uncertainty(self, calibration: Calibration) -> Uncertainty:
        """Predicted error; residuals below what any detector reaches are luck, or copies of one view."""
        u = calibration.uncertainty()
        luck = max(1.0, LEAST_NOISE * self.img_size[0] / max(calibration.noise, 1e-12))
        return Uncertainty(u.rms * luck, u.max * luck)

    def next_target(
        self, views: Sequence[View], estimate: Estimate, skipped: Sequence[TargetPose] = ()
    ) -> TargetPose:
        """Choose where to hold the board next; where targets were `skipped`, unlike them and easier."""
        return self.guide.next_pose(views, estimate.calibration, skipped)

    def judge(self, views: Sequence[View], target: TargetPose, view: View) -> Verdict:
        """Decide whether `view` joins the accepted `views`; `target` is what was asked for."""
        reason = self._unfit(view)
        if reason:
            return Verdict(False, reason, None)
        before = self.estimate(views)
        with np.errstate(all="ignore"):  # hostile numbers end in a refusal, not in a warning
            gain = self._gain(before, view)
        if gain is None:
            return Verdict(False, "outlier", None)
        after = self.estimate([*views, view])
        if after.calibration is None or self._spoils(before, after):
            return Verdict(False, "outlier", None)
        if gain < LEAST_SHARE * target.gain:
            return Verdict(False, "no_information", None)
        return Verdict(True, None, after)

    def _unfit(self, view: View) -> Reason | None:
        """Reason why a view is refused whatever came before it."""
        if len(view) < MIN_POINTS:
            return "too_few_points"
        try:
            check([view], self.img_size)
        except CalibrationError:
            return "degenerate"
        if (
            np.linalg.svd(view.image_points - view.image_points.mean(axis=0), compute_uv=False)[1]
            / np.sqrt(len(view))
            < 0.005 * self.img_size[0]
        ):
            return "degenerate"  # so far away or so oblique that it is a line, give or take the noise
        if orientation(view) < 0:
            return "mirrored"
        return None

    def _gain(self, before: Estimate, view: View) -> float | None:
        """px^2 that the view brings, by what was known before it; None where it cannot be posed."""
        belief = Belief.of(self.model, self.img_size, before.calibration)
        obs = Observations.of([view])
        posed = start.at(belief.model, obs, belief.k)
        q, j = normal.design(belief.model, belief.k, posed.poses, obs.points)
        if not (np.isfinite(q).all() and np.isfinite(j).all()):
            return None
        return belief.gain(normal.information(j, obs.mask.astype(np.float64))[0])

    def _spoils(self, before: Estimate, after: Estimate) -> bool:
        """Whether the last view of `after` does not belong to the others."""
        calibration = after.calibration
        if calibration is None:
            return True
        # Below this the corners are as good as a webcam's ever are, and a ratio says nothing.
        floor = 0.3 * self.img_size[0] / 1280
        if calibration.used[-1].mean() < 0.75 and calibration.view_errors[-1] > floor:
            return True  # wild points are cut, a few: not a good part of the view
        errors = used_errors(calibration)
        if len(errors) == 1:
            return bool(errors[0] > 10 * floor)
        others = float(np.sqrt(np.mean(errors[:-1] ** 2)))
        if errors[-1] > OUTLIER * max(others, floor):
            return True
        if before.calibration is None:
            return False
        known = float(np.sqrt(np.mean(used_errors(before.calibration) ** 2)))
        return others > OUTLIER * max(known, floor)


def used_errors(calibration: Calibration) -> Array:
    """Rms of each view (v,), px, over the points that were not cut."""
    pairs = zip(calibration.residuals, calibration.used, strict=True)
    return np.array([np.sqrt(np.mean(e[u] ** 2)) if u.any() else np.inf for e, u in pairs])


def orientation(view: View) -> float:
    """Sign of the handedness of board to image: negative in a mirrored picture.

    The determinant of the affine map that fits best; a homography's has the same sign wherever the whole
    board is in front of the camera, and this one stays defined under strong distortion too.
    """
    p = view.object_points[:, :2] - view.object_points[:, :2].mean(axis=0)
    q: Array = view.image_points - view.image_points.mean(axis=0)
    return float(np.sign(np.linalg.det(p.T @ q)))
