"""Prediction test of a view that was not yet used: its actual over its predicted reprojection error."""

import numpy as np

from .. import models
from ..arrays import Mask
from ..fitting.calibration import Calibration
from ..fitting.normal_equations import POSE_SIZE, linearize, residual_jacobian
from ..fitting.observations import Observations
from ..fitting.resection import resect
from ..fitting.validation import MIN_POINTS
from ..view import View

MAX_PREDICTION_RATIO = 2.0
"""Actual over predicted error from which the prediction does not hold."""


def prediction_ratio(calibration: Calibration, view: View, use: Mask, min_noise: float) -> float:
    """Actual over predicted rms error of a view that the calibration has not seen, its pose fitted.

    Its square is a reduced chi^2. Predicted is the noise of the corners and the uncertainty of the
    intrinsics, both as far as no pose absorbs them: with A' the part of the Jacobian by the intrinsics
    that no change of the pose explains, sigma^2 (2n - 6) + trace(A' covariance A'^T).

    Parameters
    ----------
    use
        (n,) points that are not outliers.
    min_noise
        px, of one coordinate: no detector is better.
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
