"""Pose of a board that a calibrated camera sees, with its covariance."""

from dataclasses import dataclass

import numpy as np

from . import models, rotation
from .arrays import Array, frozen
from .camera import Camera
from .errors import CalibrationError, undetermined
from .fitting.calibration import Calibration
from .fitting.levenberg_marquardt import residual_rows
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
    rows, _ = residual_rows(model, k, poses, obs)
    by_k, by_pose = (part.reshape(len(part), -1) for part in (rows[: model.size], rows[model.size : -1]))
    inverse = np.linalg.inv(by_pose @ by_pose.T)
    sum_of_squares, freedom = float(square[0]), 2 * len(view) - 6
    if noise is not None:
        sigma2 = noise**2
    elif isinstance(camera, Calibration):
        sigma2 = (sum_of_squares + PRIOR_FREEDOM * camera.noise**2) / (freedom + PRIOR_FREEDOM)
    else:
        sigma2 = sum_of_squares / freedom
    covariance = sigma2 * inverse
    if isinstance(camera, Calibration):
        by_camera = inverse @ by_pose @ by_k.T
        covariance = covariance + by_camera @ camera.covariance @ by_camera.T
    return BoardPose(
        frozen(rotation.vector(poses.r[0])),
        frozen(poses.t[0]),
        frozen((covariance + covariance.T) / 2),
        float(np.sqrt(square[0] / len(view))),
        float(np.sqrt(sigma2)),
    )
