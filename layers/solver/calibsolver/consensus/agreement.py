"""Clustering of calibrations by projection difference: a forward search, and leave-two-out influence.

Two calibrations are compared by their rays of the same pixels. A rotation of the camera frame is no
difference: it cannot be measured, and every pose absorbs it.
"""

from collections.abc import Sequence

import numpy as np

from .. import models, rotation
from ..arrays import Array, IntArray, Mask
from ..camera import Camera, pixel_grid
from ..fitting.calibration import Calibration

COMPARISON_GRID = (12, 9)
"""Columns and rows of pixels at which two calibrations are compared."""
MIN_SHARED_IMAGE = 0.5
"""Share of the image for which two calibrations must both have rays."""
MEMBER_SIGMAS = 3.0
"""Standard deviations from the others up to which a calibration belongs to them."""
SMALL_SAMPLE_INFLATION = 14.0
"""Inflation of the variance among m members: the factor is 1 + (SMALL_SAMPLE_INFLATION / (m - 1))^2."""
SPECIMEN_VARIANCE_RATIO = 4.0
"""Variance / variance that noise explains, from which specimens or sessions clearly differ."""
MIN_LEAVE_TWO_OUT_CONTRIBUTORS = 5
"""Contributors of whom two can be left out so that the others still show how much they differ."""
MIN_BIMODAL_SIZE = 8
"""Calibrations from which a sample is tested for two modes."""
MAX_UNCERTAINTY_RATIO = 2.0
"""Uncertainty / median uncertainty that a calibration is granted: vague ones do not agree with everything."""


def compare(calibrations: Sequence[Calibration]) -> Array:
    """Differences (c, c) between the projections of calibrations of one image size, px rms over the image.

    The rays of the same pixels are aligned by the best rotation (Kabsch 1976); the difference is the
    remaining angle times the local magnification. Infinite where two share less than half of the image.
    """
    return _differences([c.camera for c in calibrations])


def difference(one: Camera, other: Camera) -> float:
    """Difference between the projections of two cameras, px rms over the image, as `compare` measures it."""
    return float(_differences([one, other])[0, 1])


def _differences(cameras: Sequence[Camera]) -> Array:
    v, px, defined = _unproject_grid(cameras)
    both = defined[:, None, :] & defined[None, :, :]
    count = both.sum(axis=2)
    m = np.einsum("anb,cnd->acbd", v, v)
    r = rotation.nearest(m)  # v_a ~ r v_c
    out = np.empty((len(v), len(v)))
    for a in range(len(v)):
        aligned = np.einsum("cij,cnj->cni", r[a], v)
        angle2 = np.sum((v[a] - aligned) ** 2, axis=2)
        square = angle2 * (px[a] * px) * both[a]
        out[a] = np.sqrt(square.sum(axis=1) / np.maximum(count[a], 1))
    out[count < MIN_SHARED_IMAGE * v.shape[1]] = np.inf
    np.fill_diagonal(out, 0.0)
    return out


def _unproject_grid(cameras: Sequence[Camera]) -> tuple[Array, Array, Mask]:
    """Unproject a grid of pixels: unit rays (c, n, 3), px per radian (c, n), and a mask; 0 outside it."""
    q = pixel_grid(cameras[0].img_size, COMPARISON_GRID).reshape(2, -1)
    rays, scale = [], []
    for c in cameras:
        model, k = models.get(c.model), c.intrinsics
        v = model.unproject(k, q)
        with np.errstate(all="ignore"):
            _, _, by_p = model.jacobian(k, v)
            # Area magnification px^2 per steradian: the Jacobian is 0 along the ray.
            g = np.einsum("ian,ibn->nab", by_p, by_p)
            scale.append(np.sqrt(np.sqrt(np.maximum(np.linalg.det(g), 0))))
        rays.append(v.T)
    v, px = np.stack(rays), np.stack(scale)
    defined = np.isfinite(v[:, :, 0]) & np.isfinite(px)
    return np.where(defined[:, :, None], v, 0.0), np.where(defined, px, 0.0), defined


def displacement_fields(calibrations: Sequence[Calibration], reference: int) -> Array:
    """Displacements (c, n) of projections from those of one of the calibrations, px.

    Both coordinates of all pixels of a grid in one row, over the root of the number of pixels: the length of
    the difference of two rows is the rms difference of two calibrations. The rotation of the camera frame
    that makes it least is removed from every row.
    """
    v, _, defined = _unproject_grid([c.camera for c in calibrations])
    shared = defined.all(axis=0).mean() >= MIN_SHARED_IMAGE
    common = defined.mean(axis=0) >= 1 - 1e-9 if shared else defined[reference]
    v = v[:, common]
    base = calibrations[reference].camera
    model, k = models.get(base.model), base.intrinsics
    _, _, by_p = model.jacobian(k, v[reference].T)
    b = by_p.transpose(2, 1, 0)  # (n, 2, 3)
    r = rotation.nearest(np.einsum("nb,cnd->cbd", v[reference], v))
    displacement = np.einsum("cij,cnj->cni", r, v) - v[reference]
    x = np.einsum("nij,cnj->cni", b, displacement).reshape(len(v), -1)
    by_rotation = np.cross(v[reference][:, None, :], b).reshape(-1, 3)  # b . (w x v) = w . (v x b)
    q, _ = np.linalg.qr(by_rotation)
    out: Array = (x - (x @ q) @ q.T) / np.sqrt(max(int(common.sum()), 1))
    return out


def split_into_groups(
    calibrations: Sequence[Calibration], limit: float, harmless: float, weights: Array | None = None
) -> list[list[int]]:
    """Split calibrations into groups that agree, largest first; of equals the tightest first.

    Parameters
    ----------
    limit
        px rms over the image: calibrations that differ by more agree only if noise explains it. Those that
        differ by less must pass the `forward_search`.
    harmless
        px rms over the image below which every difference is accepted.
    weights
        (c,) weights of the calibrations in sizes and majorities; None: equal ones.
    """
    differences = compare(calibrations)
    weights = np.ones(len(calibrations)) if weights is None else weights
    own = predicted_mse(calibrations)
    bound = np.sqrt(limit**2 + MEMBER_SIGMAS**2 * (own[:, None] + own))
    left, found = list(range(len(calibrations))), []
    while left:
        d = differences[np.ix_(left, left)]
        near = [left[i] for i in largest_neighbourhood(d < bound[np.ix_(left, left)], d, weights[left])]
        group = forward_search([calibrations[i] for i in near], limit, harmless, weights[near])
        found.append([near[i] for i in group])
        left = [i for i in left if i not in found[-1]]
    return sorted(found, key=lambda group: -_total(weights[group]))


def predicted_mse(calibrations: Sequence[Calibration]) -> Array:
    """Mean square error (c,), px^2, that each calibration predicts of itself, bounded by the median's."""
    own = np.array([c.uncertainty(COMPARISON_GRID).rms for c in calibrations]) ** 2
    bounded: Array = np.minimum(own, MAX_UNCERTAINTY_RATIO**2 * np.median(own))
    return bounded


def _total(weights: Array) -> float:
    """Sum of weights, rounded so that equal sums compare equal."""
    return round(float(weights.sum()), 9)


def largest_neighbourhood(agree: Mask, differences: Array, weights: Array) -> list[int]:
    """Find the calibration that agrees with most, the tightest of equals: indices of those it agrees with."""
    counts = np.round(agree @ weights, 9)
    near = np.where(agree, differences, 0.0).sum(axis=1)
    center = min(range(len(counts)), key=lambda i: (-float(counts[i]), float(near[i])))
    return [int(i) for i in np.flatnonzero(agree[center])]


def forward_search(
    calibrations: Sequence[Calibration], limit: float, harmless: float, weights: Array | None = None
) -> list[int]:
    """Find the calibrations that belong to the densest majority: their indices.

    A forward search (Atkinson & Riani 2000). It starts with the densest half, of m members. Of the others the
    one with the least squared distance d2 from the mean of the members joins as long as d2 is explained: by
    the noise of the corners, known from the fits, and by the differences of specimens or sessions, estimated
    as the members' variance beyond their noise. That estimate is inflated for few members, and is at most
    `limit`^2. So a minority with another result of its own stays outside, however near, if there is a gap.
    Where noise is larger than the gap and bridges it, large samples are tested for two modes at the end.

    Parameters
    ----------
    limit, harmless, weights
        As of `split_into_groups`; the weights (c,) decide what half and majority are.
    """
    count = len(calibrations)
    if count < 3:
        return list(range(count))
    weights = np.ones(count) if weights is None else weights
    own = predicted_mse(calibrations)
    x = displacement_fields(calibrations, int(np.argmin(compare(calibrations).sum(axis=1))))
    members = _densest_half(x, weights)
    while len(members) < count:
        m = len(members)
        d2 = np.sum((x - np.average(x[members], axis=0, weights=weights[members])) ** 2, axis=1)
        outside = np.setdiff1d(np.arange(count), members)
        nearest = outside[np.argmin(d2[outside])]
        noise2 = float(np.mean(own[members]))
        variance = float(np.sum(d2[members])) / (m - 1)
        # Where noise alone may explain the variance, it is not inflated: few members are no excuse then.
        specimens_differ = variance > SPECIMEN_VARIANCE_RATIO * noise2
        inflation = 1 + ((SMALL_SAMPLE_INFLATION / (m - 1)) ** 2 if specimens_differ else 0.0)
        between = min(MEMBER_SIGMAS**2 * max(variance - noise2, 0.0) * inflation, limit**2)
        explained = MEMBER_SIGMAS**2 * (own[nearest] + noise2 / m) + between * (1 + 1 / m)
        if d2[nearest] > max(explained, harmless**2):
            break
        members = np.append(members, nearest)
    while (
        len(members) >= MIN_BIMODAL_SIZE
        and (part := _split_bimodal(x[members], harmless, weights[members])) is not None
    ):
        members = members[part]
    return sorted(int(i) for i in members)


def leave_two_out_influence(
    calibrations: Sequence[Calibration], contributors: Sequence[str]
) -> tuple[float, float]:
    """Leave-two-out influence of contributors on the mean of the calibrations, and the specimens' spread.

    Every contributor weighs the same. The influence, px rms over the image, is the distance by which the
    mean moves without the two contributors that move it most; infinite where there are only two. The spread,
    px, is 0 where noise explains that of the densest majority, else the standard deviation of the other
    contributors beyond their noise; of fewer than five contributors, that of the densest majority.
    """
    names, who = np.unique(np.asarray(contributors), return_inverse=True)
    if len(names) < 3:
        return np.inf, 0.0
    weights = 1 / np.bincount(who)[who]
    x = displacement_fields(calibrations, int(np.argmin(compare(calibrations).sum(axis=1))))
    noise2 = predicted_mse(calibrations)
    means = np.stack([np.average(x[who == c], axis=0) for c in range(len(names))])
    shift, others = max_leave_two_out_shift(means)
    members = _densest_half(x, weights)
    variance, expected = _variance(x[members], weights[members]), float(np.mean(noise2[members]))
    if variance <= SPECIMEN_VARIANCE_RATIO * expected:
        return shift, 0.0
    if len(names) >= MIN_LEAVE_TWO_OUT_CONTRIBUTORS:
        own2 = [np.mean(noise2[who == c]) / np.sum(who == c) for c in others]
        variance, expected = _variance(means[others], np.ones(len(others))), float(np.mean(own2))
    return shift, float(np.sqrt(max(variance - expected, 0.0)))


def _variance(x: Array, weights: Array) -> float:
    """Mean square distance of rows (c, n) from their weighted mean."""
    return float(np.sum((x - np.average(x, axis=0, weights=weights)) ** 2)) / max(len(x) - 1, 1)


def max_leave_two_out_shift(x: Array) -> tuple[float, IntArray]:
    """Largest shift of the mean of rows (c, n), c >= 3, when two are left out; indices of the other rows."""
    # Without a and b the mean of c rows lies at -(a + b) / (c - 2) from that of all.
    centered = x - x.mean(axis=0)
    square = np.sum(centered**2, axis=1)
    pairs = square[:, None] + square + 2 * centered @ centered.T
    np.fill_diagonal(pairs, -1.0)
    worst = np.unravel_index(np.argmax(pairs), pairs.shape)
    others = np.setdiff1d(np.arange(len(x)), worst)
    return float(np.sqrt(max(pairs[worst], 0.0))) / (len(x) - 2), others


def _split_bimodal(x: Array, harmless: float, weights: Array) -> IntArray | None:
    """Find the larger of two modes of the rows (c, n): its indices; None where the rows have one mode.

    The measure is, along the first principal component, the distance of the two means over the standard
    deviation within (Ashman et al. 1994). Of normally distributed rows one in a hundred sets exceeds the
    threshold. Modes less than `harmless` px apart are one.
    """
    centered = x - x.mean(axis=0)
    along = centered @ np.linalg.svd(centered, full_matrices=False)[2][0]
    order = np.argsort(along)
    sorted_along, count = along[order], len(along)
    best, split = 0.0, 0
    for size in range(2, count - 1):
        low, high = sorted_along[:size], sorted_along[size:]
        within = float(np.sqrt((np.var(low) * len(low) + np.var(high) * len(high)) / (count - 2)))
        separation = float(high.mean() - low.mean()) / max(within, 1e-12)
        if separation > best and separation * within > harmless:
            best, split = separation, size
    if best < 3.2 + 28 / count:
        return None
    low, high = order[:split], order[split:]
    side: IntArray = low if _total(weights[low]) >= _total(weights[high]) else high
    return side


def _densest_half(x: Array, weights: Array) -> IntArray:
    """Find the rows with most of the weight that lie closest together around one of them: their indices."""
    d = np.linalg.norm(x[:, None] - x[None], axis=2)
    order = np.argsort(d, axis=1)
    total = np.cumsum(weights[order], axis=1)
    last = np.argmax(total > total[:, -1:] / 2 + 1e-9, axis=1)
    center = np.argmin(np.take_along_axis(d, np.take_along_axis(order, last[:, None], axis=1), axis=1)[:, 0])
    chosen: IntArray = order[center, : last[center] + 1]
    return chosen
