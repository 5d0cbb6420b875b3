"""Homographies from boards to the rays on which they are seen (DLT), many at once, and their poses.

If some points of a view are wrong, by least median of squares (LMedS): of homographies through random samples
the one whose median error over the view's points is least (Rousseeuw 1984; Fischler & Bolles 1981), then the
one through all its inliers.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .. import deadline, rotation
from ..arrays import Array, IntArray, Mask
from .normal_equations import Poses

SINGULAR = 1e-14
"""Smallest eigenvalue / trace of a matrix, at least."""
SQUARINGS = 4
"""Squarings of the inverse: each doubles the iterations."""
SAMPLES, SAMPLE_SIZE = 60, 5
"""Homographies tried for a view, and points for each: of five points three in four must be good."""
MAX_CURVATURE = 0.03
"""Median error of a homography / extent of the view: lenses do not bend images by more, wrong ids do."""
INLIER_LMEDS_MEDIANS = 3.0


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


def fit_homographies_lmeds(
    points: Array, rays: Array, mask: Mask, allowed: float = MAX_CURVATURE
) -> tuple[Homographies, Array]:
    """Homographies of views (v) through all points in the mask (v, n), or the inliers if that is much better.

    Also returns the weights (v, n), 0 or 1, of these points. `points` and unit `rays` are (v, 3, n), rays may
    be NaN. All points of a view are trusted up to a median error / extent that is `allowed`.
    """
    usable = mask & np.isfinite(rays[:, 0])
    if not usable.all():
        rays = np.where(usable[:, None], rays, 0.0)
    weights = usable.astype(np.float64)
    out = Homographies.fit_dlt(points, rays, weights)
    error = medians(out.errors(points, rays), usable)
    center = (rays @ weights[:, :, None]) / np.maximum(weights.sum(axis=1), 1.0)[:, None, None]
    extent = np.sqrt(((rays - center) ** 2 * weights[:, None]).sum(axis=(1, 2)) / weights.sum(axis=1))
    for i in np.flatnonzero(~(error <= allowed * extent) & (usable.sum(axis=1) > SAMPLE_SIZE)):
        deadline.check()
        agree, best = lmeds_inliers(points[i], rays[i], usable[i])
        if best < error[i] / 2:
            weights[i] = agree
    changed = (weights != usable).any()
    return (Homographies.fit_dlt(points, rays, weights) if changed else out), weights


def lmeds_inliers(points: Array, rays: Array, usable: Mask) -> tuple[Mask, float]:
    """Inliers (n,) of one view by LMedS, and the median error of the best sample, radians."""
    index = np.flatnonzero(usable)
    drawn = index[samples_of(len(index))]
    xyz, rays_of_samples = (np.moveaxis(each[:, drawn], 0, 1) for each in (points, rays))
    tried = Homographies.fit_dlt(xyz, rays_of_samples, np.ones(drawn.shape))
    error = tried.errors(points, rays)
    middle = medians(error, np.broadcast_to(usable, error.shape))
    best = int(np.argmin(middle))
    agree: Mask = usable & (error[best] <= INLIER_LMEDS_MEDIANS * middle[best])
    return agree, float(middle[best])


@lru_cache(maxsize=64)
def samples_of(count: int) -> IntArray:
    """Samples (SAMPLES, SAMPLE_SIZE) of so many points, the same every time."""
    order = np.random.default_rng(count).random((SAMPLES, count)).argsort(axis=1)
    return order[:, :SAMPLE_SIZE]


def medians(values: Array, mask: Mask) -> Array:
    """Median (v,) of the values (v, n) in the mask, the lower of two; inf if there is none."""
    half = np.maximum(mask.sum(axis=1) - 1, 0) // 2
    if half.min() == half.max() and mask.all():
        middle: Array = np.partition(values, half[0], axis=1)[:, half[0]]
        return middle
    # The others stand at the end of the order, where they are not counted.
    order = np.sort(np.where(mask, np.nan_to_num(values, nan=np.inf), np.inf), axis=1)
    out: Array = order[np.arange(len(order)), half]
    return out
