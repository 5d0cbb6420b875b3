"""Initial guess of the solver: poses for a given focal length by resection, and a focal length.

Without distortion the rays of a plane's points are a homography of them: ray ~ H (X, Y, 1). That is true
beyond 90 degrees from the axis, as long as the ray keeps its sign, so one linear solution serves narrow
lenses and fisheyes. (Hartley & Zisserman, "Multiple View Geometry", 4.1 and 8.1.)
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, IntArray, Mask, subsample
from ..camera import Camera
from ..models import Model
from .homography import Homographies, fit_homographies_lmeds
from .normal_equations import Poses
from .observations import MIX, Observations

MAX_TRIAL_VIEWS = 10


@dataclass(frozen=True, eq=False)
class Start:
    """Initial guess of one optimum: intrinsics k (p,) and poses.

    `error` is the median distance of the projected points, px. `weights` (v, n) are 0 where a point
    contradicts most of its view.
    """

    k: Array
    poses: Poses
    error: float = float("nan")
    weights: Array | None = None


def plane_poses(points: Array, rays: Array, weights: Array) -> Poses:
    """Poses of planes (v, 3, n), board frame, z = 0, seen along unit rays (v, 3, n) of weight (v, n).

    Rays may be NaN.
    """
    usable = np.isfinite(rays[:, 0]) & (weights > 0)
    if not usable.all():
        weights = np.where(usable, weights, 0.0)
        rays = np.where(usable[:, None, :], rays, 0.0)
    return Homographies.fit_dlt(points, rays, weights).poses(points[:, 2, 0])


def at(model: Model, obs: Observations, k: Array) -> Start:
    """Start from intrinsics k (p,)."""
    return evaluate_starts(model, obs, [k])[0]


def evaluate_starts(model: Model, obs: Observations, many: list[Array]) -> list[Start]:
    """Evaluate starts from several intrinsics (p,), all poses solved at once."""
    pixels = obs.pixels.transpose(1, 0, 2)
    rays = np.concatenate([model.unproject(k, pixels).transpose(1, 0, 2) for k in many])
    points, mask = np.tile(obs.points, (len(many), 1, 1)), np.tile(obs.mask, (len(many), 1))
    poses = plane_poses(points, rays, mask.astype(np.float64))
    v, middle = obs.view_count, obs.count // 2
    out = []
    for i, k in enumerate(many):
        part = slice(i * v, (i + 1) * v)
        of_k = poses.subset(part)
        p = of_k.camera_points(obs.points).transpose(1, 0, 2)
        with np.errstate(all="ignore"):  # what lies behind the camera is masked out
            away = np.where(model.valid(k[4:], p), model.project(k, p) - pixels, np.inf)
        distances = np.hypot(away[0], away[1])[obs.mask]
        out.append(Start(k, of_k, float(np.partition(distances, middle)[middle])))
    return out


def focal_sweep(model: Model, obs: Observations, img_size: tuple[int, int]) -> list[Start]:
    """Starts from all initial intrinsics of the model, the best of each family first."""
    starts = evaluate_starts(model, obs, model.initial_intrinsics(img_size))
    each = len(starts) // model.start_families
    families = [
        sorted(starts[i * each : (i + 1) * each], key=lambda start: start.error)
        for i in range(model.start_families)
    ]
    return [start for rank in zip(*families, strict=True) for start in rank]


def from_vanishing_points(model: Model, obs: Observations, img_size: tuple[int, int]) -> Iterator[Start]:
    """Yield the start from vanishing points (Zhang 2000) if the undistorted model is a pinhole."""
    if not model.is_perspective:
        return
    k = model.start(float(img_size[0]), img_size)
    rays = unproject_observations(model, obs, k)
    homographies, weights = fit_homographies_lmeds(obs.points, rays, obs.mask)
    factor = homographies.focal_from_vanishing_points()
    if 0.2 < factor < 8:
        k[:2] /= factor
        yield Start(k, homographies.with_focal_scale(factor).poses(obs.points[:, 2, 0]), weights=weights)


def with_robust_poses(model: Model, obs: Observations, k: Array) -> Start:
    """Start from intrinsics k (p,) and the poses of the inliers of each view."""
    homographies, weights = fit_homographies_lmeds(
        obs.points, unproject_observations(model, obs, k), obs.mask
    )
    return Start(k, homographies.poses(obs.points[:, 2, 0]), weights=weights)


def unproject_observations(model: Model, obs: Observations, k: Array) -> Array:
    """Unit rays (v, 3, n) of the pixels under intrinsics k (p,); NaN where there are none."""
    return model.unproject(k, obs.pixels.transpose(1, 0, 2)).transpose(1, 0, 2)


def convert_intrinsics(model: Model, camera: Camera) -> Array:
    """Intrinsics (p,) of a model, the same or another, similar to a camera's."""
    theirs = camera.intrinsics
    if camera.model == model.name:
        return theirs
    k = model.start(float(np.sqrt(np.prod(camera.focal))), camera.img_size)
    k[2:4] = theirs[2:4]
    return k


def subsample_views(obs: Observations, mask: Mask) -> IntArray | None:
    """Choose MAX_TRIAL_VIEWS views from all over the image, by their content; None if there are no more."""
    usable = np.flatnonzero(mask.any(axis=1))
    if len(usable) <= MAX_TRIAL_VIEWS:
        return None if len(usable) == obs.view_count else usable
    weight = obs.mask[usable] / obs.mask[usable].sum(axis=1, keepdims=True)
    x, y = (obs.pixels[usable] * weight[:, None]).sum(axis=2).T
    order = np.argsort(x + MIX * y, kind="stable")
    return usable[order[subsample(len(usable), MAX_TRIAL_VIEWS)]]
