"""Every view is a test before it is used: how far off it is, against how far off it was predicted to be."""

import numpy as np

from .. import models
from ..arrays import Mask
from ..fitting import normal_equations
from ..fitting.calibration import Calibration
from ..fitting.observations import Observations
from ..fitting.resection import resect
from ..view import View

DISAGREEMENT = 2.0
"""Actual over predicted error from which the prediction does not hold."""


def surprise(calibration: Calibration, view: View, use: Mask, least_noise: float) -> float:
    """Actual over predicted rms error of a view that the calibration has not seen, its pose fitted.

    Predicted is the noise of the corners and the uncertainty of the intrinsics, both as far as no pose
    absorbs them: with [A | B] the view's Jacobian by intrinsics and pose, and A' what B cannot explain of A,
    sigma^2 (2n - 6) + trace(A' covariance A'^T).

    Parameters
    ----------
    use
        (n,) points that are no outliers.
    least_noise
        px, of one coordinate: no detector is better.
    """
    if use.sum() < 6:
        return 1.0
    seen = View(view.object_points[use], view.image_points[use])
    model, k = models.get(calibration.camera.model), calibration.camera.intrinsics
    obs = Observations.of([seen])
    poses, square = resect(model, k, obs)
    _, j = normal_equations.design(model, k, poses, obs.points)
    flat = j[0].reshape(model.size + 6, -1).T
    if not (np.isfinite(square).all() and np.isfinite(flat).all()):
        return np.inf
    a, b = flat[:, : model.size], flat[:, model.size :]
    scale = np.maximum(np.linalg.norm(b, axis=0), 1e-300)
    q, _ = np.linalg.qr(b / scale)
    left = a - q @ (q.T @ a)
    noise = max(calibration.noise, least_noise)
    predicted = noise**2 * (len(flat) - 6) + float(np.sum((left @ calibration.covariance) * left))
    return float(np.sqrt(square[0] / predicted))
