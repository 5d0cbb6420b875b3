"""Where the solver starts: poses for a given focal length, and a focal length.

For a model without distortion every pixel is a ray, and the rays of a plane's points are a homography of
them: ray ~ H (X, Y, 1). That holds beyond 90 degrees from the axis too, as long as the ray keeps its sign,
so one linear solution serves narrow lenses and fisheyes. (Hartley & Zisserman, "Multiple View Geometry",
4.1 and 8.1.)
"""

from dataclasses import dataclass

import numpy as np

from . import rotation
from .arrays import Array
from .models import Model
from .normal import Poses
from .observations import Observations


@dataclass(frozen=True, eq=False)
class Start:
    """Intrinsics (p,), poses, and the median angular error of that start in px of its focal length."""

    k: Array
    poses: Poses
    error: float


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
    w = np.where(usable, weights, 0.0)
    ray = np.where(usable[:, None, :], rays, 0.0)
    total = np.maximum(w.sum(axis=1), 1e-9)
    xy = points[:, :2]
    mean = np.einsum("vin,vn->vi", xy, w) / total[:, None]
    spread = np.sqrt(np.einsum("vin,vn->v", (xy - mean[:, :, None]) ** 2, w) / total / 2)
    spread = np.maximum(spread, 1e-300)
    x = np.ones((len(points), 3, points.shape[2]))
    x[:, :2] = (xy - mean[:, :, None]) / spread[:, None, None]
    # |ray x (H X)|^2 summed = h' [sum (1 - ray ray') (x) X X'] h
    v, _, n = ray.shape
    outer = (x[:, :, None, :] * x[:, None, :, :]).reshape(v, 9, n) * w[:, None, :]
    shadow = (np.eye(3)[None, :, :, None] - ray[:, :, None, :] * ray[:, None, :, :]).reshape(v, 9, n)
    m = (shadow @ outer.transpose(0, 2, 1)).reshape(v, 3, 3, 3, 3).transpose(0, 1, 3, 2, 4).reshape(v, 9, 9)
    h = np.linalg.eigh(m)[1][:, :, 0].reshape(v, 3, 3)
    side = np.einsum("vin,vij,vjn,vn->v", ray, h, x, w)
    h = h * np.where(side < 0, -1.0, 1.0)[:, None, None]
    length = (np.linalg.norm(h[:, :, 0], axis=1) + np.linalg.norm(h[:, :, 1], axis=1)) / 2
    h = h / np.maximum(length, 1e-300)[:, None, None]
    first, second = h[:, :, 0], h[:, :, 1]
    r = rotation.nearest(np.stack([first, second, np.cross(first, second)], axis=2))
    t = h[:, :, 2] * spread[:, None]
    t = t - np.einsum("vij,vj->vi", r[:, :, :2], mean)
    # A plane of constant z other than 0 only moves the origin.
    t = t - r[:, :, 2] * points[:, 2, :1]
    poses = Poses(r, t)
    p = poses.camera_points(points)
    p = p / np.maximum(np.linalg.norm(p, axis=1, keepdims=True), 1e-300)
    angle = np.linalg.norm(p - ray, axis=1)
    return poses, np.where(usable, angle, 0.0)


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
        focal = np.sqrt(k[0] * k[1]) * model.magnification(k[4:])[0]
        error = float(np.median(angle[part][obs.mask]) * focal)
        out.append(Start(k, Poses(poses.r[part], poses.t[part]), error))
    return out


def ladder(model: Model, obs: Observations, img_size: tuple[int, int]) -> list[Start]:
    """Try every focal length of the model, on at most ten of the views: starts, best first."""
    few = np.unique(np.linspace(0, obs.view_count - 1, min(10, obs.view_count)).astype(int))
    rungs = [model.start(f * img_size[0], img_size) for f in model.ladder]
    return sorted(tried(model, obs.subset(few), rungs), key=lambda start: start.error)
