"""Homography from a board to the rays on which it is seen (DLT), many at once, and its pose."""

from dataclasses import dataclass

import numpy as np

from .. import rotation
from ..arrays import Array
from .normal_equations import Poses

SINGULAR = 1e-14
"""Smallest eigenvalue / trace of a matrix, at least."""
SQUARINGS = 4
"""Squarings of the inverse: each doubles the iterations."""


@dataclass(frozen=True, eq=False)
class Homographies:
    """Homographies of planes: ray ~ h (X, Y, 1), X = (x - mean) / spread.

    `h` is (v, 3, 3), the mean length of its first two columns 1, `mean` (v, 2), `spread` (v,).
    """

    h: Array
    mean: Array
    spread: Array

    @classmethod
    def fit_dlt(cls, points: Array, rays: Array, weights: Array) -> "Homographies":
        """Direct linear transform of points (v, 3, n) to unit rays (v, 3, n), finite, of weight (v, n).

        |ray x (H X)|^2 summed = h' [sum (1 - ray ray') (x) X X'] h is least for the smallest eigenvector.
        """
        v, _, n = rays.shape
        xy = points[:, :2]
        total = np.maximum(weights.sum(axis=1), 1e-9)
        mean = (xy @ weights[:, :, None])[:, :, 0] / total[:, None]
        x = np.ones((v, 3, n))
        np.subtract(xy, mean[:, :, None], out=x[:, :2])
        square = (x[:, 0] ** 2 + x[:, 1] ** 2) * weights
        spread = np.sqrt(square.sum(axis=1) / total / 2)
        spread = np.where(spread > 0, spread, 1.0)  # nothing, or one place, is seen of it
        x[:, :2] /= spread[:, None, None]
        outer = (x[:, :, None, :] * (x * weights[:, None])[:, None, :, :]).reshape(v, 9, n)
        shadow = (np.eye(3)[None, :, :, None] - rays[:, :, None, :] * rays[:, None, :, :]).reshape(v, 9, n)
        m = (shadow @ outer.transpose(0, 2, 1)).reshape(v, 3, 3, 3, 3).transpose(0, 1, 3, 2, 4)
        m = m.reshape(v, 9, 9)
        h = smallest_eigenvectors(m).reshape(v, 3, 3)
        side = ((h @ x) * rays).sum(axis=1) * weights
        h = h * np.where(side.sum(axis=1) < 0, -1.0, 1.0)[:, None, None]
        return cls(normalize_scale(h), mean, spread)

    def errors(self, points: Array, rays: Array) -> Array:
        """Angular errors (v, n), radians, small ones, of points (v, 3, n) against unit rays (v, 3, n).

        Points and rays (3, n) are those of all planes.
        """
        x = np.ones((len(self.h), *points.shape[-2:]))
        x[:, :2] = (points[..., :2, :] - self.mean[:, :, None]) / self.spread[:, None, None]
        p = self.h @ x
        e = p / np.maximum(np.sqrt(np.einsum("vin,vin->vn", p, p)), 1e-300)[:, None] - rays
        out: Array = np.sqrt(np.einsum("vin,vin->vn", e, e))
        return out

    def with_focal_scale(self, factor: float) -> "Homographies":
        """Homographies of the same planes where rays have `factor` times the distance from the axis."""
        return Homographies(
            normalize_scale(self.h * np.array([factor, factor, 1.0])[:, None]), self.mean, self.spread
        )

    def poses(self, offset: Array) -> Poses:
        """Nearest poses of the planes; a plane of constant z = `offset` (v,) only moves the origin."""
        first, second = self.h[:, :, 0], self.h[:, :, 1]
        r = rotation.nearest(np.stack([first, second, np.cross(first, second)], axis=2))
        t = self.h[:, :, 2] * self.spread[:, None]
        t = t - (r[:, :, :2] @ self.mean[:, :, None])[:, :, 0] - r[:, :, 2] * offset[:, None]
        return Poses(r, t)

    def focal_from_vanishing_points(self) -> float:
        """Factor for `with_focal_scale` that makes the first two columns orthogonal, of one length.

        Zhang 2000, with square pixels and a known centre; NaN if all planes face the camera.
        """
        (x1, y1, z1), (x2, y2, z2) = self.h[:, :, 0].T, self.h[:, :, 1].T
        image = np.concatenate([x1 * x2 + y1 * y2, (x1 * x1 + y1 * y1 - x2 * x2 - y2 * y2) / 2])
        depth = np.concatenate([z1 * z2, (z1 * z1 - z2 * z2) / 2])
        below = float(image @ image)
        return float(np.sqrt(-(image @ depth) / below)) if below > 0 else float("nan")


def smallest_eigenvectors(m: Array) -> Array:
    """Unit eigenvectors (v, p) of the smallest eigenvalues of positive semidefinite matrices (v, p, p).

    By inverse iteration, which is fast, and approximate where two eigenvalues are near.
    """
    size = m.shape[-1]
    shifted = m / (np.trace(m, axis1=1, axis2=2)[:, None, None] + 1e-300)
    shifted.reshape(len(m), -1)[:, :: size + 1] += SINGULAR
    power = np.linalg.inv(shifted)
    power /= np.trace(power, axis1=1, axis2=2)[:, None, None]  # no power of it overflows
    for _ in range(SQUARINGS):
        power = power @ power
    best = np.argmax(np.diagonal(power, axis1=1, axis2=2), axis=1)
    x = power[np.arange(len(m)), best]
    out: Array = x / np.sqrt((x * x).sum(axis=1, keepdims=True))
    return out


def normalize_scale(h: Array) -> Array:
    """Homographies (v, 3, 3) of which the first two columns have mean length 1."""
    columns = np.sqrt((h[:, :, :2] ** 2).sum(axis=1)).sum(axis=1) / 2
    out: Array = h / np.maximum(columns, 1e-300)[:, None, None]
    return out
