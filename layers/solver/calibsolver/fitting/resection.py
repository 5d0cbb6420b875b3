"""How well a given camera explains views: the poses alone are fitted."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import models
from ..arrays import Array, Mask, frozen
from ..camera import Camera
from ..errors import CalibrationError
from ..models import Model
from ..view import View
from . import initial_guess, normal_equations
from .normal_equations import Poses
from .observations import Observations
from .validation import in_range

ITERATIONS = 30
SETTLED = 1e-8
"""Relative decrease of a view's squared error below which its pose is left."""
LEAST_POINTS = 4
"""Of a plane, that make a pose."""


@dataclass(frozen=True, eq=False)
class Score:
    """The error of a camera on views it need not have been fitted to.

    Attributes
    ----------
    rms
        px, root of the mean square distance over all points of all views; infinite where a view cannot be
        explained at all.
    view_errors
        (v,) px, the same for each view.
    poses
        (v, 6) rvec|tvec, board -> camera, board units; NaN where a view cannot be explained at all.
    """

    rms: float
    view_errors: Array
    poses: Array


def score(camera: Camera, views: Sequence[View]) -> Score:
    """Measure the reprojection error of `views` under `camera`, every pose fitted, nothing left out.

    Raises CalibrationError (``no_views``, ``too_few_points``, ``out_of_range``).
    """
    if not views:
        raise CalibrationError("no_views", "there is no view to score")
    if min(len(view) for view in views) < LEAST_POINTS:
        raise CalibrationError("too_few_points", f"a pose needs {LEAST_POINTS} points")
    obs = in_range(Observations.of(views), camera.img_size)
    poses, square = resect(models.get(camera.model), camera.intrinsics, obs)
    count = obs.mask.sum(axis=1)
    with np.errstate(all="ignore"):
        vectors = np.where(np.isfinite(square)[:, None], poses.vectors(), np.nan)
    return Score(float(np.sqrt(square.sum() / count.sum())), frozen(np.sqrt(square / count)), frozen(vectors))


def resect(model: Model, k: Array, obs: Observations) -> tuple[Poses, Array]:
    """Fit the pose of every view under intrinsics k (p,): poses, and summed squared distances (v,) px^2.

    Levenberg-Marquardt from the linear solution, every view with its own damping. The sum is infinite where
    the camera cannot see a view.
    """
    with np.errstate(all="ignore"):  # views that these intrinsics cannot explain run away
        poses = initial_guess.at(model, obs, k).poses
        here, h, g = _normal(model, k, poses, obs)
        damping = np.full(len(here), 1e-6)
        active = np.isfinite(here)
        for _ in range(ITERATIONS):
            if not active.any():
                break
            moved = poses.moved(_steps(h, g, damping, active))
            cost, h_moved, g_moved = _normal(model, k, moved, obs)
            better = active & (cost < here)
            gained = np.where(better, here - cost, 0.0)
            poses = Poses(
                np.where(better[:, None, None], moved.r, poses.r), np.where(better[:, None], moved.t, poses.t)
            )
            h, g = np.where(better[:, None, None], h_moved, h), np.where(better[:, None], g_moved, g)
            settled = better & (gained < SETTLED * here)
            here = np.where(better, cost, here)
            damping = np.where(better, damping * 0.1, np.maximum(damping, 1e-6) * 100)
            active &= ~settled & (damping < 1e6)
    return poses, np.where(np.isfinite(here), here, np.inf)


def _normal(model: Model, k: Array, poses: Poses, obs: Observations) -> tuple[Array, Array, Array]:
    """Squared error (v,), its Gauss-Newton matrix (v, 6, 6) and half gradient (v, 6) by the poses."""
    q, j = normal_equations.design(model, k, poses, obs.points)
    r = np.where(obs.mask[:, None, :], q - obs.pixels, 0.0).reshape(len(q), -1)
    b = np.where(obs.mask[:, None, None, :], j[:, model.size :], 0.0).reshape(len(q), 6, -1)
    return np.sum(r * r, axis=1), b @ b.transpose(0, 2, 1), np.einsum("vij,vj->vi", b, r)


def _steps(h: Array, g: Array, damping: Array, active: Mask) -> Array:
    """Damped steps (v, 6); none for views that are not active."""
    usable = active & np.isfinite(h).all(axis=(1, 2)) & np.isfinite(g).all(axis=1)
    h = np.where(usable[:, None, None], h, np.eye(6))
    scale = 1 / np.sqrt(np.maximum(np.diagonal(h, axis1=1, axis2=2), 1e-300))
    unit = h * scale[:, :, None] * scale[:, None, :] + (damping + 1e-12)[:, None, None] * np.eye(6)
    solved = np.linalg.solve(unit, (scale * np.where(usable[:, None], g, 0.0))[:, :, None])[:, :, 0]
    step: Array = -scale * solved
    return step
