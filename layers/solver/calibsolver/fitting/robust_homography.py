"""Planes of views of which a part is wrong: corners under others' names, other things taken for corners.

Of homographies through some points each, the one whose median error over the view's points is least
(Rousseeuw 1984; Fischler & Bolles 1981), then the one through all points that agree with it.
"""

import numpy as np

from ..arrays import Array, Mask
from .homography import Planes

SAMPLES, SAMPLE = 60, 5
"""Homographies tried for a view, and points for each: of five points three in four must be good."""
CURVED = 0.03
"""Median error of a homography / extent of the view: lenses do not bend images by more, wrong names do."""


def planes(points: Array, rays: Array, mask: Mask, allowed: float = CURVED) -> tuple[Planes, Array]:
    """Homographies of views (v) by all points, or by the majority where that is much better.

    Also returns the weights (v, n), 0 or 1, of the points that they go through.

    Parameters
    ----------
    points
        (v, 3, n), board frame.
    rays
        (v, 3, n) unit rays, camera frame; NaN where there are none.
    mask
        (v, n) points that count.
    allowed
        Median error / extent of a view up to which all its points are trusted.
    """
    usable = mask & np.isfinite(rays[:, 0])
    if not usable.all():
        rays = np.where(usable[:, None], rays, 0.0)
    weights = usable.astype(np.float64)
    out = Planes.seen(points, rays, weights)
    error = medians(out.errors(points, rays), usable)
    center = (rays @ weights[:, :, None]) / np.maximum(weights.sum(axis=1), 1.0)[:, None, None]
    extent = np.sqrt(((rays - center) ** 2 * weights[:, None]).sum(axis=(1, 2)) / weights.sum(axis=1))
    for i in np.flatnonzero(~(error <= allowed * extent) & (usable.sum(axis=1) > SAMPLE)):
        agree, best = agreeing(points[i], rays[i], usable[i])
        if best < error[i] / 2:
            weights[i] = agree
    changed = (weights != usable).any()
    return (Planes.seen(points, rays, weights) if changed else out), weights


def agreeing(points: Array, rays: Array, usable: Mask) -> tuple[Mask, float]:
    """Inlier mask (n,) of one view under the best sample (LMedS), and its median error, radians.

    Which samples is a fixed choice: the same every time.
    """
    index = np.flatnonzero(usable)
    order = np.random.default_rng(len(index)).random((SAMPLES, len(index))).argsort(axis=1)
    weights = np.zeros((SAMPLES, len(usable)))
    np.put_along_axis(weights, index[order[:, :SAMPLE]], 1.0, axis=1)
    many = np.broadcast_to(points, (SAMPLES, *points.shape)), np.broadcast_to(rays, (SAMPLES, *rays.shape))
    error = Planes.seen(*many, weights).errors(*many)
    middle = medians(error, np.broadcast_to(usable, error.shape))
    best = int(np.argmin(middle))
    agree: Mask = usable & (error[best] <= 3 * middle[best])
    return agree, float(middle[best])


def medians(values: Array, mask: Mask) -> Array:
    """Median (v,) of the values (v, n) that the mask holds, the lower of two; inf where there is none."""
    half = np.maximum(mask.sum(axis=1) - 1, 0) // 2
    if half.min() == half.max() and mask.all():
        middle: Array = np.partition(values, half[0], axis=1)[:, half[0]]
        return middle
    # The others stand at the end of the order, where they are not counted.
    order = np.sort(np.where(mask, np.nan_to_num(values, nan=np.inf), np.inf), axis=1)
    out: Array = order[np.arange(len(order)), half]
    return out
