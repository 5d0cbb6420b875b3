"""Robust homographies of views in which some points are wrong.

Least median of squares (LMedS): of homographies through random samples the one whose median error over the
view's points is least (Rousseeuw 1984; Fischler & Bolles 1981), then the one through all its inliers.
"""

from functools import lru_cache

import numpy as np

from .. import deadline
from ..arrays import Array, IntArray, Mask
from .homography import Homographies

SAMPLES, SAMPLE_SIZE = 60, 5
"""Homographies tried for a view, and points for each: of five points three in four must be good."""
MAX_CURVATURE = 0.03
"""Median error of a homography / extent of the view: lenses do not bend images by more, wrong ids do."""
INLIER_LMEDS_MEDIANS = 3.0


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
