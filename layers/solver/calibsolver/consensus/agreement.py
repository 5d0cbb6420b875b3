"""Which calibrations of one camera agree: measured in the image, grouped, those that do not belong cut.

Two calibrations are compared by what they say of the same pixels. A turn of the camera frame is no
difference: nobody can measure it, and every pose absorbs it.
"""

from collections.abc import Sequence

import numpy as np

from .. import models, rotation
from ..arrays import Array, IntArray, Mask
from ..camera import Camera, pixel_grid
from ..fitting.calibration import Calibration

GRID = (12, 9)
SHARED = 0.5
"""Share of the image that two calibrations must both see."""
BEYOND = 3.0
"""Standard deviations beyond which a calibration does not belong to the others."""
FEW = 14.0
"""What the spread among a few may hide: of m its square is multiplied by 1 + (FEW / (m - 1))^2."""
CLEARLY = 4.0
"""Square of the spread / of what noise explains, from which specimens or sessions clearly differ."""
FEWEST = 5
"""Contributors of whom two may be left out and the others still show how much they differ."""
MANY = 8
"""Calibrations that show whether they are two heaps."""
BOAST = 2.0
"""Times the typical uncertainty of all that is believed of one: who is vague does not agree with all."""


def compare(calibrations: Sequence[Calibration]) -> Array:
    """Differences (c, c) between the projections of calibrations of one image size, px rms over the image.

    The rays of the same pixels, turned onto each other as well as can be (Kabsch 1976), and the remaining
    angles times the local magnification. Infinite where two share less than half of the image.
    """
    return _differences([c.camera for c in calibrations])


def difference(one: Camera, other: Camera) -> float:
    """Difference between the projections of two cameras, px rms over the image, as `compare` measures it."""
    return float(_differences([one, other])[0, 1])


def _differences(cameras: Sequence[Camera]) -> Array:
    v, px, seen = _rays(cameras)
    both = seen[:, None, :] & seen[None, :, :]
    count = both.sum(axis=2)
    m = np.einsum("anb,cnd->acbd", v, v)
    turn = rotation.nearest(m)  # v_a ~ turn v_c
    out = np.empty((len(v), len(v)))
    for a in range(len(v)):
        moved = np.einsum("cij,cnj->cni", turn[a], v)
        angle2 = np.sum((v[a] - moved) ** 2, axis=2)
        square = angle2 * (px[a] * px) * both[a]
        out[a] = np.sqrt(square.sum(axis=1) / np.maximum(count[a], 1))
    out[count < SHARED * v.shape[1]] = np.inf
    np.fill_diagonal(out, 0.0)
    return out


def _rays(cameras: Sequence[Camera]) -> tuple[Array, Array, Mask]:
    """Return unit rays (c, n, 3) of a grid of pixels, px per radian (c, n), and which exist; else 0."""
    q = pixel_grid(cameras[0].img_size, GRID).reshape(2, -1)
    rays, scale = [], []
    for c in cameras:
        law, k = models.get(c.model), c.intrinsics
        v = law.unproject(k, q)
        with np.errstate(all="ignore"):
            _, _, by_p = law.jacobian(k, v)
            # Area magnification px^2 per steradian: the Jacobian is 0 along the ray.
            g = np.einsum("ian,ibn->nab", by_p, by_p)
            scale.append(np.sqrt(np.sqrt(np.maximum(np.linalg.det(g), 0))))
        rays.append(v.T)
    v, px = np.stack(rays), np.stack(scale)
    seen = np.isfinite(v[:, :, 0]) & np.isfinite(px)
    return np.where(seen[:, :, None], v, 0.0), np.where(seen, px, 0.0), seen


def fields(calibrations: Sequence[Calibration], reference: int) -> Array:
    """Displacements (c, n) of projections from those of one of the calibrations, px.

    Both coordinates of all pixels of a grid in one row, over the root of the number of pixels: the length of
    the difference of two rows is the rms difference of two calibrations. The turn of the camera frame that
    makes it least is taken out of every row.
    """
    v, _, seen = _rays([c.camera for c in calibrations])
    common = seen.mean(axis=0) >= 1 - 1e-9 if seen.all(axis=0).mean() >= SHARED else seen[reference]
    v = v[:, common]
    base = calibrations[reference].camera
    law, k = models.get(base.model), base.intrinsics
    _, _, by_p = law.jacobian(k, v[reference].T)
    b = by_p.transpose(2, 1, 0)  # (n, 2, 3)
    turned = rotation.nearest(np.einsum("nb,cnd->cbd", v[reference], v))
    moved = np.einsum("cij,cnj->cni", turned, v) - v[reference]
    x = np.einsum("nij,cnj->cni", b, moved).reshape(len(v), -1)
    free = np.cross(v[reference][:, None, :], b).reshape(-1, 3)  # b . (w x v) = w . (v x b)
    q, _ = np.linalg.qr(free)
    out: Array = (x - (x @ q) @ q.T) / np.sqrt(max(int(common.sum()), 1))
    return out


def groups(
    calibrations: Sequence[Calibration], limit: float, harmless: float, weights: Array | None = None
) -> list[list[int]]:
    """Split calibrations into groups that agree, largest first; of equals the tightest first.

    `weights` (c,) say how much each counts in what is large and what is a majority; None: as much as any.

    `limit` is the difference, px rms over the image, beyond which only noise can be an excuse. What is nearer
    agrees if its distance from the others is explained too (`gather`); below `harmless`, px, no explanation
    is asked for.
    """
    differences = compare(calibrations)
    weights = np.ones(len(calibrations)) if weights is None else weights
    own = predicted(calibrations)
    bound = np.sqrt(limit**2 + BEYOND**2 * (own[:, None] + own))
    left, found = list(range(len(calibrations))), []
    while left:
        d = differences[np.ix_(left, left)]
        near = [left[i] for i in largest(d < bound[np.ix_(left, left)], d, weights[left])]
        group = gather([calibrations[i] for i in near], limit, harmless, weights[near])
        found.append([near[i] for i in group])
        left = [i for i in left if i not in found[-1]]
    return sorted(found, key=lambda group: -_counted(weights[group]))


def predicted(calibrations: Sequence[Calibration]) -> Array:
    """Return the mean square error (c,), px^2, that each calibration predicts of itself, if believable."""
    own = np.array([c.uncertainty(GRID).rms for c in calibrations]) ** 2
    bounded: Array = np.minimum(own, BOAST**2 * np.median(own))
    return bounded


def _counted(weights: Array) -> float:
    """Sum of weights, without the rounding by which equals would differ."""
    return round(float(weights.sum()), 9)


def largest(agree: Mask, differences: Array, weights: Array) -> list[int]:
    """Find the largest set whose members all agree with one of them; the tightest of equals."""
    counts = np.round(agree @ weights, 9)
    near = np.where(agree, differences, 0.0).sum(axis=1)
    center = min(range(len(counts)), key=lambda i: (-float(counts[i]), float(near[i])))
    return [int(i) for i in np.flatnonzero(agree[center])]


def gather(
    calibrations: Sequence[Calibration], limit: float, harmless: float, weights: Array | None = None
) -> list[int]:
    """Find those that belong to the tightest majority of calibrations: their indices.

    A forward search (Atkinson & Riani 2000): from the tightest half, the next nearest joins as long as its
    distance from the middle of those already in is explained. What the noise of the corners explains is known
    from the fits. What specimens of a product, or sessions, differ by on top of it is learnt from those
    already in, of whom a few know little; but it is never more than `limit`, px rms over the image. So a
    minority that agrees with itself on something else stays outside, however near, if there is a gap. Where
    the noise is larger than the gap, so that it was bridged, the two heaps of many still show. What half and
    majority are is told by the `weights` (c,); None: equal ones.
    """
    count = len(calibrations)
    if count < 3:
        return list(range(count))
    weights = np.ones(count) if weights is None else weights
    own = predicted(calibrations)
    x = fields(calibrations, int(np.argmin(compare(calibrations).sum(axis=1))))
    inner = _tightest(x, weights)
    while len(inner) < count:
        size = len(inner)
        distance2 = np.sum((x - np.average(x[inner], axis=0, weights=weights[inner])) ** 2, axis=1)
        outside = np.setdiff1d(np.arange(count), inner)
        nearest = outside[np.argmin(distance2[outside])]
        noise2 = float(np.mean(own[inner]))
        spread2 = float(np.sum(distance2[inner])) / (size - 1)
        # Where noise alone may be at work, a larger spread that it might hide is no excuse.
        hidden = (FEW / (size - 1)) ** 2 if spread2 > CLEARLY * noise2 else 0.0
        more = min(BEYOND**2 * max(spread2 - noise2, 0.0) * (1 + hidden), limit**2)
        explained = BEYOND**2 * (own[nearest] + noise2 / size) + more * (1 + 1 / size)
        if distance2[nearest] > max(explained, harmless**2):
            break
        inner = np.append(inner, nearest)
    while len(inner) >= MANY and (part := _larger_side(x[inner], harmless, weights[inner])) is not None:
        inner = inner[part]
    return sorted(int(i) for i in inner)


def sway(calibrations: Sequence[Calibration], contributors: Sequence[str]) -> tuple[float, float]:
    """How far what calibrations agree on hangs on two contributors, px rms over the image.

    Every contributor weighs the same. Returned are the distance by which the middle moves without those two
    that move it most, and by how much specimens differ: 0 where noise explains the spread of the tightest
    majority, else the spread beyond the noise of the contributors but those two. Of fewer than five the
    others would show nothing: there it is the tightest majority's; with two the distance is infinite.
    """
    names, who = np.unique(np.asarray(contributors), return_inverse=True)
    if len(names) < 3:
        return np.inf, 0.0
    weights = 1 / np.bincount(who)[who]
    x = fields(calibrations, int(np.argmin(compare(calibrations).sum(axis=1))))
    noise2 = predicted(calibrations)
    each = np.stack([np.average(x[who == c], axis=0) for c in range(len(names))])
    far, others = without_two(each)
    inner = _tightest(x, weights)
    spread2, least2 = _spread2(x[inner], weights[inner]), float(np.mean(noise2[inner]))
    if spread2 <= CLEARLY * least2:
        return far, 0.0
    if len(names) >= FEWEST:
        own2 = [np.mean(noise2[who == c]) / np.sum(who == c) for c in others]
        spread2, least2 = _spread2(each[others], np.ones(len(others))), float(np.mean(own2))
    return far, float(np.sqrt(max(spread2 - least2, 0.0)))


def _spread2(x: Array, weights: Array) -> float:
    """Mean square distance of rows (c, n) from their middle."""
    return float(np.sum((x - np.average(x, axis=0, weights=weights)) ** 2)) / max(len(x) - 1, 1)


def without_two(each: Array) -> tuple[float, IntArray]:
    """How far the middle of rows (c, n), c >= 3, moves without the two that move it most, and who is left."""
    # Without a and b the middle of c rows lies at -(a + b) / (c - 2) from that of all.
    from_middle = each - each.mean(axis=0)
    square = np.sum(from_middle**2, axis=1)
    pairs = square[:, None] + square + 2 * from_middle @ from_middle.T
    np.fill_diagonal(pairs, -1.0)
    worst = np.unravel_index(np.argmax(pairs), pairs.shape)
    others = np.setdiff1d(np.arange(len(each)), worst)
    return float(np.sqrt(max(pairs[worst], 0.0))) / (len(each) - 2), others


def _larger_side(x: Array, harmless: float, weights: Array) -> IntArray | None:
    """Find the larger of two heaps that the rows fall into: its indices; None where there is one heap.

    Along the direction in which they differ most, the distance of the two means over the spread within
    (Ashman et al. 1994). Of normally distributed rows one in a hundred sets shows more than is asked for.
    Heaps less than `harmless` px apart are one.
    """
    centered = x - x.mean(axis=0)
    along = centered @ np.linalg.svd(centered, full_matrices=False)[2][0]
    order = np.argsort(along)
    sorted_along, count = along[order], len(along)
    best, at = 0.0, 0
    for size in range(2, count - 1):
        low, high = sorted_along[:size], sorted_along[size:]
        within = float(np.sqrt((np.var(low) * len(low) + np.var(high) * len(high)) / (count - 2)))
        apart = float(high.mean() - low.mean()) / max(within, 1e-12)
        if apart > best and apart * within > harmless:
            best, at = apart, size
    if best < 3.2 + 28 / count:
        return None
    low, high = order[:at], order[at:]
    side: IntArray = low if _counted(weights[low]) >= _counted(weights[high]) else high
    return side


def _tightest(x: Array, weights: Array) -> IntArray:
    """Find the rows with most of the weight that lie closest together around one of them: their indices."""
    d = np.linalg.norm(x[:, None] - x[None], axis=2)
    order = np.argsort(d, axis=1)
    held = np.cumsum(weights[order], axis=1)
    last = np.argmax(held > held[:, -1:] / 2 + 1e-9, axis=1)
    center = np.argmin(np.take_along_axis(d, np.take_along_axis(order, last[:, None], axis=1), axis=1)[:, 0])
    chosen: IntArray = order[center, : last[center] + 1]
    return chosen
