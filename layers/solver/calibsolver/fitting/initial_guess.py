"""Initial guess of the solver: poses for a given focal length, and a focal length.

For a model without distortion every pixel is a ray, and the rays of a plane's points are a homography of
them: ray ~ H (X, Y, 1). That holds beyond 90 degrees from the axis too, as long as the ray keeps its sign,
so one linear solution serves narrow lenses and fisheyes. (Hartley & Zisserman, "Multiple View Geometry",
4.1 and 8.1.)
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, IntArray, Mask
from ..camera import Camera
from ..models import Model
from . import robust_homography
from .homography import Planes, from_rays
from .normal_equations import Poses
from .observations import Observations

FEW = 10
"""Views on which starts are tried."""


@dataclass(frozen=True, eq=False)
class Start:
    """Initial intrinsics and poses.

    Attributes
    ----------
    k, poses
        Intrinsics (p,), poses.
    error
        Median angular error in px of its focal length.
    weights
        (v, n) 0 where a point contradicts most of its view; None where nothing is known of that.
    """

    k: Array
    poses: Poses
    error: float = float("nan")
    weights: Array | None = None


def plane_poses(points: Array, rays: Array, weights: Array) -> tuple[Poses, Array]:
    """Poses of planes (v) seen along unit rays, and the angular errors (v, n), radians.

    Parameters
    ----------
    points
        (v, 3, n), board frame, z = 0.
    rays
        (v, 3, n) unit rays, camera frame; NaN where the weight is 0 at the latest.
    weights
        (v, n)
    """
    usable = np.isfinite(rays[:, 0]) & (weights > 0)
    if not usable.all():
        weights = np.where(usable, weights, 0.0)
        rays = np.where(usable[:, None, :], rays, 0.0)
    poses = Planes.seen(points, rays, weights).poses(points[:, 2, 0])
    return poses, np.where(usable, from_rays(poses.camera_points(points), rays), 0.0)


def at(model: Model, obs: Observations, k: Array) -> Start:
    """Start from intrinsics k (p,)."""
    return tried(model, obs, [k])[0]


def tried(model: Model, obs: Observations, many: list[Array]) -> list[Start]:
    """Start from each of several intrinsics (p,), all solved at once."""
    pixels = obs.pixels.transpose(1, 0, 2)
    rays = np.concatenate([model.unproject(k, pixels).transpose(1, 0, 2) for k in many])
    points, mask = np.tile(obs.points, (len(many), 1, 1)), np.tile(obs.mask, (len(many), 1))
    poses, angle = plane_poses(points, rays, mask.astype(np.float64))
    v = obs.view_count
    out = []
    for i, k in enumerate(many):
        part = slice(i * v, (i + 1) * v)
        # What the start does not see at all is no better than what it sees in the wrong place.
        blind = np.isnan(rays[part, 0])
        focal = np.sqrt(k[0] * k[1]) * model.magnification(k[4:])[0]
        error = float(np.median(np.where(blind, np.inf, angle[part])[obs.mask]) * focal)
        out.append(Start(k, Poses(poses.r[part], poses.t[part]), error))
    return out


def ladder(model: Model, obs: Observations, img_size: tuple[int, int]) -> list[Start]:
    """Try every rung of the model: starts, the best of each kind first."""
    rungs = tried(model, obs, model.initial_intrinsics(img_size))
    each = len(rungs) // model.start_families
    kinds = [
        sorted(rungs[i * each : (i + 1) * each], key=lambda start: start.error)
        for i in range(model.start_families)
    ]
    return [start for rank in zip(*kinds, strict=True) for start in rank]


def direct(model: Model, obs: Observations, img_size: tuple[int, int]) -> Iterator[Start]:
    """Yield the start from vanishing points, for a model without distortion a pinhole, or nothing."""
    if not model.is_perspective:
        return
    k = model.start(float(img_size[0]), img_size)
    rays = seen(model, obs, k)
    planes, weights = robust_homography.planes(obs.points, rays, obs.mask)
    factor = planes.stretch()
    if 0.2 < factor < 8:
        k[:2] /= factor
        yield Start(k, planes.stretched(factor).poses(obs.points[:, 2, 0]), weights=weights)


def mended(model: Model, obs: Observations, first: Start) -> Start:
    """Return a start whose poses follow the majority of the points of each view."""
    planes, weights = robust_homography.planes(obs.points, seen(model, obs, first.k), obs.mask)
    return Start(first.k, planes.poses(obs.points[:, 2, 0]), first.error, weights)


def seen(model: Model, obs: Observations, k: Array) -> Array:
    """Return unit rays (v, 3, n) of the pixels under intrinsics k (p,); NaN where there are none."""
    return model.unproject(k, obs.pixels.transpose(1, 0, 2)).transpose(1, 0, 2)


def like(model: Model, camera: Camera) -> Array:
    """Intrinsics (p,) of a model that resemble a camera's, of this model or another."""
    theirs = camera.intrinsics
    if camera.model == model.name:
        return theirs
    k = model.start(float(np.sqrt(theirs[0] * theirs[1])) * camera.magnification, camera.img_size)
    k[2:4] = theirs[2:4]
    return k


def few(obs: Observations, mask: Mask) -> IntArray | None:
    """Choose views (FEW,) to try starts on, from all over the image; None where there are no more.

    Chosen by what they show, not by their order.
    """
    usable = np.flatnonzero(mask.any(axis=1))
    if len(usable) <= FEW:
        return None if len(usable) == obs.view_count else usable
    weight = obs.mask[usable] / obs.mask[usable].sum(axis=1, keepdims=True)
    x, y = (obs.pixels[usable] * weight[:, None]).sum(axis=2).T
    order = np.argsort(x + 0.618 * y, kind="stable")
    return usable[order[np.linspace(0, len(usable) - 1, FEW).round().astype(np.int64)]]
