"""Resection: the poses of views under a given camera, by reprojection error (PnP for all views at once)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import deadline, models
from ..arrays import Array, frozen
from ..camera import Camera
from ..errors import CalibrationError, undetermined
from ..models import Model
from ..view import View
from . import initial_guess
from .levenberg_marquardt import MAX_DAMPING, assess_step, residual_rows
from .normal_equations import Poses, System
from .observations import Observations
from .validation import in_range

MAX_ITERATIONS = 60
FIRST_DAMPING = 1e-6
MIN_DECREASE = 1e-8
MIN_POSE_POINTS = 4
ASSESS_STEPS = np.frompyfunc(assess_step, 3, 2)


@dataclass(frozen=True, eq=False)
class ReprojectionScore:
    """Reprojection error of a camera on views it need not have been fitted to.

    Attributes
    ----------
    rms, view_errors
        px, root of the mean square distance over all points, and of each view (v,); infinite if a view cannot
        be explained.
    poses
        (v, 6) rvec|tvec, board -> camera, board units; NaN if a view cannot be explained.
    """

    rms: float
    view_errors: Array
    poses: Array


@undetermined()
def reprojection_score(camera: Camera, views: Sequence[View]) -> ReprojectionScore:
    """Reprojection error of `views` under `camera`: all poses fitted, all points alike.

    Raises CalibrationError (``no_views``, ``too_few_points``, ``out_of_range``).
    """
    if not views:
        raise CalibrationError("no_views", "there is no view to score")
    if min(len(view) for view in views) < MIN_POSE_POINTS:
        raise CalibrationError("too_few_points", f"a pose needs {MIN_POSE_POINTS} points")
    obs = replace(in_range(Observations.of(views), camera.img_size), scale=None)
    poses, square = resect(models.get(camera.model), camera.intrinsics, obs)
    count = obs.mask.sum(axis=1)
    with np.errstate(all="ignore"):
        vectors = np.where(np.isfinite(square)[:, None], poses.vectors(), np.nan)
    return ReprojectionScore(
        float(np.sqrt(square.sum() / count.sum())), frozen(np.sqrt(square / count)), frozen(vectors)
    )


def resect(model: Model, k: Array, obs: Observations) -> tuple[Poses, Array]:
    """Fit the pose of every view under intrinsics k (p,): poses, and summed squared distances (v,) px^2.

    Levenberg-Marquardt from the linear solution, with a damping and an accept test for each view. The sum is
    infinite if the camera cannot see a view.
    """
    with np.errstate(all="ignore"):  # views that these intrinsics cannot explain run away
        poses = initial_guess.at(model, obs, k).poses
        rows, cost = pose_rows(model, k, poses, obs)
        damping = np.full(len(cost), FIRST_DAMPING)
        active = np.isfinite(cost)
        views = np.arange(len(cost))
        for _ in range(MAX_ITERATIONS):
            deadline.check()
            if not active.all():  # only the views that are still on their way are worked on
                views, damping, rows = views[active], damping[active], rows[:, :, active]
                obs = obs.subset(np.flatnonzero(active))
            if not views.size:
                break
            before = cost[views]
            step, predicted = System.of(rows, None).pose_steps(damping)
            moved = poses.subset(views).retract(step)
            moved_rows, after = pose_rows(model, k, moved, obs)
            accepted, damping = (x.astype(float) for x in ASSESS_STEPS(damping, before - after, predicted))
            better = accepted > 0
            poses = poses.replace(views[better], moved.subset(better))
            cost[views[better]] = after[better]
            rows = np.where(better[:, None], moved_rows, rows)
            decrease = np.where(better, before - after, np.inf)
            active = (np.minimum(decrease, predicted) > MIN_DECREASE * before) & (damping < MAX_DAMPING)
    return poses, np.where(np.isfinite(cost), cost, np.inf)


def pose_rows(model: Model, k: Array, poses: Poses, obs: Observations) -> tuple[Array, Array]:
    """Jacobian by the pose and residuals (7, 2, v, n), px, and summed squared distances (v,), px^2.

    Of points that were measured; the rows of a view that the camera cannot see are 0.
    """
    rows, square = residual_rows(model, k, poses, obs)
    rows = rows[model.size :]
    if not obs.mask.all():
        rows, square = np.where(obs.mask, rows, 0.0), np.where(obs.mask, square, 0.0)
    rows[:, :, ~np.isfinite(rows.sum(axis=(0, 1, 3)))] = 0.0
    return rows, square.sum(axis=1)
