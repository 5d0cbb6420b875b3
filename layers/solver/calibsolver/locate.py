"""Pose of a board that a calibrated camera sees, with its covariance."""

from dataclasses import dataclass

import numpy as np

from . import models, rotation
from .arrays import Array, frozen
from .camera import Camera
from .errors import CalibrationError, undetermined
from .fitting.calibration import Calibration
from .fitting.observations import Observations
from .fitting.resection import resect
from .fitting.validation import MIN_POINTS
from .view import View

PRIOR_FREEDOM = 20.0
"""Degrees of freedom of the calibration's noise, next to the residuals of the view."""


@dataclass(frozen=True, eq=False)
class BoardPose:
    """Pose of a board, x -> R x + t from the board's frame to the camera's.

    Attributes
    ----------
    rvec, tvec
        (3,) rotation vector, radians, and translation, units of the object points.
    covariance
        (6, 6) of a small turn of the board in the camera frame, radians (R becomes exp(w) R), and of t, by
        the noise of the corners and the covariance of the camera.
    rms
        px, root of the (weighted) mean square distance.
    noise
        px, standard deviation of one coordinate of a corner, of mean weight.
    """

    rvec: Array
    tvec: Array
    covariance: Array
    rms: float
    noise: float

    @property
    def matrix(self) -> Array:
        """(4, 4) homogeneous transform, board -> camera."""
        out = np.eye(4)
        out[:3, :3], out[:3, 3] = rotation.matrix(np.asarray(self.rvec)), self.tvec
        return out

    @property
    def std(self) -> Array:
        """(6,) standard deviations: the diagonal of `covariance`."""
        return np.sqrt(np.diagonal(self.covariance))


@undetermined()
def locate(camera: Camera | Calibration, view: View, *, noise: float | None = None) -> BoardPose:
    """Locate a flat board, or any points of a plane, that a known camera sees.

    Parameters
    ----------
    camera
        A `Calibration`, whose covariance counts, or a `Camera`, which is taken as exact.
    view
        At least six points, not all on a line.
    noise
        px of one coordinate of a corner; None: estimated from the residuals and the noise of the calibration.

    Raises CalibrationError ``too_few_points``, or ``not_believable`` if no pose explains the view.
    """
    if len(view) < MIN_POINTS:
        raise CalibrationError("too_few_points", f"a pose needs {MIN_POINTS} points, not {len(view)}")
    known = camera.camera if isinstance(camera, Calibration) else camera
    model, k = models.get(known.model), known.intrinsics
    obs = Observations.of([view])
    poses, square = resect(model, k, obs)
    if not np.isfinite(square[0]):
        raise CalibrationError("not_believable", "the camera cannot see the points anywhere")
    turned = poses.r[0] @ view.object_points.T
    _, by_k, by_point = model.jacobian(k, turned + poses.t[0][:, None])
    if obs.scale is not None:
        by_k, by_point = by_k * obs.scale[0], by_point * obs.scale[0]
    # d(exp(w) R X) = w x (R X)
    by_turn = np.cross(turned.T[:, None, :], by_point.transpose(2, 1, 0))
    rows = np.concatenate([by_turn, by_point.transpose(2, 1, 0)], axis=2).reshape(-1, 6)
    inverse = np.linalg.inv(rows.T @ rows)
    sigma2 = noise**2 if noise is not None else _variance(camera, float(square[0]), 2 * len(view) - 6)
    covariance = sigma2 * inverse
    if isinstance(camera, Calibration):
        by_camera = inverse @ rows.T @ by_k.transpose(2, 1, 0).reshape(-1, model.size)
        covariance = covariance + by_camera @ camera.covariance @ by_camera.T
    return BoardPose(
        frozen(rotation.vector(poses.r[0])),
        frozen(poses.t[0]),
        frozen((covariance + covariance.T) / 2),
        float(np.sqrt(square[0] / len(view))),
        float(np.sqrt(sigma2)),
    )


def _variance(camera: Camera | Calibration, square: float, freedom: int) -> float:
    """Variance of one coordinate, px^2: of the residuals, pooled with that of the calibration."""
    prior = PRIOR_FREEDOM if isinstance(camera, Calibration) else 0.0
    known = camera.noise**2 if isinstance(camera, Calibration) else 0.0
    return (square + prior * known) / (freedom + prior)
