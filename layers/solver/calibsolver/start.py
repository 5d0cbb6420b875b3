"""Where the solver starts: poses for a given focal length, and a focal length.

For a model without distortion every pixel is a ray, and the rays of a plane's points are a homography of
them: ray ~ H (X, Y, 1). That holds beyond 90 degrees from the axis too, as long as the ray keeps its sign,
so one linear solution serves narrow lenses and fisheyes. (Hartley & Zisserman, "Multiple View Geometry",
4.1 and 8.1.)
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from . import rotation
from .arrays import Array, IntArray, Mask
from .camera import Camera
from .models import Model
from .normal import Poses
from .observations import Observations

FEW = 10
"""Views on which starts are tried."""


@dataclass(frozen=True, eq=False)
class Start:
    """Intrinsics (p,), poses, and the median angular error of that start in px of its focal length."""

    k: Array
    poses: Poses
    error: float


@dataclass(frozen=True, eq=False)
class Planes:
    """Homographies of planes (v): ray ~ h (X, Y, 1) with (X, Y) centred and scaled.

    Attributes
    ----------
    h
        (v, 3, 3), the mean length of the first two columns 1.
    mean, spread
        (v, 2) and (v,): X = (x - mean) / spread.
    """

    h: Array
    mean: Array
    spread: Array

    @classmethod
    def seen(cls, points: Array, rays: Array, weights: Array) -> "Planes":
        """From points (v, 3, n), unit rays (v, 3, n) and weights (v, n) as of `plane_poses`, rays finite.

        |ray x (H X)|^2 summed = h' [sum (1 - ray ray') (x) X X'] h is least for the smallest eigenvector.
        """
        v, _, n = rays.shape
        xy = points[:, :2]
        total = np.maximum(weights.sum(axis=1), 1e-9)
        mean = (xy @ weights[:, :, None])[:, :, 0] / total[:, None]
        x = np.ones((v, 3, n))
        np.subtract(xy, mean[:, :, None], out=x[:, :2])
        square = (x[:, 0] ** 2 + x[:, 1] ** 2) * weights
        spread = np.maximum(np.sqrt(square.sum(axis=1) / total / 2), 1e-300)
        x[:, :2] /= spread[:, None, None]
        outer = (x[:, :, None, :] * (x * weights[:, None])[:, None, :, :]).reshape(v, 9, n)
        shadow = (np.eye(3)[None, :, :, None] - rays[:, :, None, :] * rays[:, None, :, :]).reshape(v, 9, n)
        m = (shadow @ outer.transpose(0, 2, 1)).reshape(v, 3, 3, 3, 3).transpose(0, 1, 3, 2, 4)
        h = np.linalg.eigh(m.reshape(v, 9, 9))[1][:, :, 0].reshape(v, 3, 3)
        side = ((h @ x) * rays).sum(axis=1) * weights
        h = h * np.where(side.sum(axis=1) < 0, -1.0, 1.0)[:, None, None]
        return cls(scaled(h), mean, spread)

    def stretched(self, factor: float) -> "Planes":
        """Take the same planes where rays have `factor` times the distance from the axis."""
        return Planes(scaled(self.h * np.array([factor, factor, 1.0])[:, None]), self.mean, self.spread)

    def poses(self, offset: Array) -> Poses:
        """Nearest poses of the planes; a plane of constant z = `offset` (v,) only moves the origin."""
        first, second = self.h[:, :, 0], self.h[:, :, 1]
        r = rotation.nearest(np.stack([first, second, np.cross(first, second)], axis=2))
        t = self.h[:, :, 2] * self.spread[:, None]
        t = t - (r[:, :, :2] @ self.mean[:, :, None])[:, :, 0] - r[:, :, 2] * offset[:, None]
        return Poses(r, t)

    def stretch(self) -> float:
        """Find the factor for `stretched` that makes the first two columns orthogonal and equally long.

        Their vanishing points lie at right angles (Zhang 2000, with square pixels and a known centre);
        NaN where all planes face the camera.
        """
        (x1, y1, z1), (x2, y2, z2) = self.h[:, :, 0].T, self.h[:, :, 1].T
        image = np.concatenate([x1 * x2 + y1 * y2, (x1 * x1 + y1 * y1 - x2 * x2 - y2 * y2) / 2])
        depth = np.concatenate([z1 * z2, (z1 * z1 - z2 * z2) / 2])
        below = float(image @ image)
        return float(np.sqrt(-(image @ depth) / below)) if below > 0 else float("nan")


def scaled(h: Array) -> Array:
    """Homographies (v, 3, 3) of which the first two columns have mean length 1."""
    columns = np.sqrt((h[:, :, :2] ** 2).sum(axis=1)).sum(axis=1) / 2
    out: Array = h / np.maximum(columns, 1e-300)[:, None, None]
    return out


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
    return poses, np.where(usable, angles(poses, points, rays), 0.0)


def angles(poses: Poses, points: Array, rays: Array) -> Array:
    """Angles (v, n), radians, small ones, between points (v, 3, n) and unit rays (v, 3, n)."""
    p = poses.camera_points(points)
    e = p / np.maximum(np.sqrt((p * p).sum(axis=1, keepdims=True)), 1e-300) - rays
    out: Array = np.sqrt((e * e).sum(axis=1))
    return out


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
    """Try every rung of the model: starts, best first."""
    return sorted(tried(model, obs, model.rungs(img_size)), key=lambda start: start.error)


def direct(model: Model, obs: Observations, img_size: tuple[int, int]) -> Iterator[Start]:
    """Yield the start from vanishing points, for a model without distortion a pinhole, or nothing."""
    if not model.straight:
        return
    k = model.start(float(img_size[0]), img_size)
    rays = model.unproject(k, obs.pixels.transpose(1, 0, 2)).transpose(1, 0, 2)
    planes = Planes.seen(obs.points, rays, obs.mask.astype(np.float64))
    factor = planes.stretch()
    if 0.2 < factor < 8:
        k[:2] /= factor
        yield Start(k, planes.stretched(factor).poses(obs.points[:, 2, 0]), np.nan)


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
