"""Error on views that took no part in the fit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import models
from ..arrays import Array, Mask, frozen
from ..camera import Camera
from ..errors import CalibrationError, undetermined
from ..fitting.calibration import Calibration
from ..fitting.constraint import Fix
from ..fitting.fit import fit
from ..fitting.normal_equations import POSE_SIZE, linearize, residual_jacobian
from ..fitting.observations import Observations
from ..fitting.resection import reprojection_score, resect
from ..fitting.validation import MIN_POINTS, degenerate_views, pack
from ..view import View

FOLDS = 5


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Result of a cross-validation: px, rms over all points, and (v,) of each view when it was left out.

    A degenerate view, which has no pose, has NaN.
    """

    rms: float
    view_errors: Array


@undetermined()
def held_out(
    views: Sequence[View],
    img_size: tuple[int, int],
    model: str = "rectilinear",
    *,
    board_shape: bool = True,
    start: Camera | None = None,
    fix: Fix = (),
) -> HeldOut:
    """Cross-validate: intrinsics from the training views, the poses of the held-out views fitted.

    The parameters are those of `fit`. View i is left out in part i mod FOLDS. Raises CalibrationError
    ``too_few_views`` if no training view is left, or what a fit raises.
    """
    part = np.arange(len(views)) % FOLDS
    if len(views):
        part = np.where(degenerate_views(pack(views, img_size)), -1, part)
    parts = [np.flatnonzero(part == p).tolist() for p in np.unique(part[part >= 0])]
    if not parts or any(len(left) == len(views) for left in parts):
        raise CalibrationError("too_few_views", "without the views left out there are none to fit")
    errors, counts = np.full(len(views), np.nan), np.array([len(view) for view in views])
    for left in parts:
        training = [view for i, view in enumerate(views) if i not in left]
        found = fit(training, img_size, model, start=start, fix=fix, board_shape=board_shape)
        shaped = found.shaped([views[i] for i in left])
        errors[left] = reprojection_score(found.camera, shaped).view_errors
    seen = part >= 0
    return HeldOut(float(np.sqrt(np.average(errors[seen] ** 2, weights=counts[seen]))), frozen(errors))


MAX_PREDICTION_RATIO = 2.0
"""Actual over predicted error from which the prediction does not hold."""


def prediction_ratio(calibration: Calibration, view: View, use: Mask, min_noise: float) -> float:
    """Actual over predicted rms error of a view that the calibration has not seen, its pose fitted.

    Its square is a reduced chi^2. Predicted is the noise of the corners and the uncertainty of the
    intrinsics, as far as no pose absorbs them: sigma^2 (2n - 6) + trace(A' covariance A'^T), with A' the
    part of the Jacobian by the intrinsics that no change of the pose explains. `use` (n,): points that are
    not outliers; `min_noise`: px, of one coordinate, no detector is better.
    """
    if use.sum() < MIN_POINTS:
        return 1.0
    seen = view.subset(use)
    model, k = models.get(calibration.camera.model), calibration.camera.intrinsics
    obs = Observations.of(calibration.shaped([seen]))
    poses, square = resect(model, k, obs)
    _, rows = linearize(model, k, poses, obs.points, 0)
    if not (np.isfinite(square).all() and np.isfinite(rows).all()):
        return np.inf
    left = residual_jacobian(rows)[0]
    noise = max(calibration.noise, min_noise)
    predicted = noise**2 * (len(left) - POSE_SIZE) + float(np.sum((left @ calibration.covariance) * left))
    return float(np.sqrt(square[0] / predicted))
