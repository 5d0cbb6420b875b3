"""Clustering of calibrations by projection difference: a forward search.

Two calibrations are compared by their rays of the same pixels. A rotation of the camera frame is no
difference: it cannot be measured, and every pose absorbs it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

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
SPECIMEN_SPREAD_WIDTHS = 0.00083
"""Prior standard deviation between specimens, rms over the image / image width: 0.25 % of the focal length,
where calibrations of real specimens of one product differ by 0.1 to 0.4 %."""
SPECIMEN_SPREAD_MEMBERS = 2.0
"""Degrees of freedom that this prior is worth."""
MIN_BIMODAL_SIZE = 8
"""Calibrations from which a sample is tested for two modes."""
MAX_UNCERTAINTY_RATIO = 2.0
"""Uncertainty / median uncertainty that a calibration is granted: vague ones do not agree with everything."""


@dataclass(frozen=True, eq=False)
class Projections:
    """Projections of calibrations of one image size, sampled on a grid of pixels.

    Attributes
    ----------
    cameras
        Cameras of the c calibrations.
    rays
        (c, n, 3) unit rays of the pixels, camera frame; 0 where a camera has none.
    scale
        (c, n) local magnification, px per radian; 0 where a camera has no ray.
    defined
        (c, n) whether a camera has a ray.
    mse
        (c,) mean square error over the image that each calibration predicts of itself, px^2.
    """

    cameras: tuple[Camera, ...]
    rays: Array
    scale: Array
    defined: Mask
    mse: Array

    @classmethod
    def of(cls, calibrations: Sequence[Calibration]) -> "Projections":
        """Sample calibrations."""
        mse = np.array([c.uncertainty(COMPARISON_GRID).rms for c in calibrations]) ** 2
        return cls.of_cameras([c.camera for c in calibrations], mse)

    @classmethod
    def of_cameras(cls, cameras: Sequence[Camera], mse: Array | None = None) -> "Projections":
        """Sample cameras; without `mse` (c,) they are exact."""
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
        return cls(
            tuple(cameras),
            np.where(defined[:, :, None], v, 0.0),
            np.where(defined, px, 0.0),
            defined,
            np.zeros(len(v)) if mse is None else mse,
        )

    def __len__(self) -> int:
        return len(self.cameras)

    def subset(self, indices: Sequence[int] | IntArray) -> "Projections":
        """Projections of some of the calibrations."""
        chosen = np.asarray(indices, dtype=np.intp)
        out = Projections(
            tuple(self.cameras[i] for i in chosen),
            self.rays[chosen],
            self.scale[chosen],
            self.defined[chosen],
            self.mse[chosen],
        )
        if "differences" in self.__dict__:
            out.__dict__["differences"] = self.differences[np.ix_(chosen, chosen)]
        return out

    @cached_property
    def differences(self) -> Array:
        """Differences (c, c) between projections, px rms over the image.

        The rays of the same pixels are aligned by the best rotation (Kabsch 1976); the difference is the
        remaining angle times the local magnification. Infinite where two share less than half of the image.
        """
        v, px, defined = self.rays, self.scale, self.defined
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

    @property
    def medoid(self) -> int:
        """Index of the calibration that lies closest to all the others."""
        return int(np.argmin(self.differences.sum(axis=1)))

    @property
    def bounded_mse(self) -> Array:
        """`mse` (c,), bounded by the median's."""
        bounded: Array = np.minimum(self.mse, MAX_UNCERTAINTY_RATIO**2 * np.median(self.mse))
        return bounded


def compare(calibrations: Sequence[Calibration]) -> Array:
    """Differences (c, c) between the projections of calibrations of one image size (see `Projections`)."""
    return Projections.of_cameras([c.camera for c in calibrations]).differences


def difference(one: Camera, other: Camera) -> float:
    """Difference between the projections of two cameras, px rms over the image, as `compare` measures it."""
    return float(Projections.of_cameras([one, other]).differences[0, 1])


def displacement_fields(projections: Projections, reference: int) -> Array:
    """Displacements (c, n) of projections from those of one of the calibrations, px.

    Both coordinates of all pixels of a grid in one row, over the root of the number of pixels: the length of
    the difference of two rows is the rms difference of two calibrations. The rotation of the camera frame
    that makes it least is removed from every row.
    """
    v, defined = projections.rays, projections.defined
    shared = defined.all(axis=0).mean() >= MIN_SHARED_IMAGE
    common = defined.mean(axis=0) >= 1 - 1e-9 if shared else defined[reference]
    v = v[:, common]
    base = projections.cameras[reference]
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
    projections: Projections, limit: float, harmless: float, weights: Array | None = None
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
    differences, own = projections.differences, projections.bounded_mse
    weights = np.ones(len(projections)) if weights is None else weights
    bound = np.sqrt(limit**2 + MEMBER_SIGMAS**2 * (own[:, None] + own))
    left, found = list(range(len(projections))), []
    while left:
        d = differences[np.ix_(left, left)]
        near = [left[i] for i in largest_neighbourhood(d < bound[np.ix_(left, left)], d, weights[left])]
        group = forward_search(projections.subset(near), limit, harmless, weights[near])
        found.append([near[i] for i in group])
        left = [i for i in left if i not in found[-1]]
    return sorted(found, key=lambda group: -_total(weights[group]))


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
    projections: Projections, limit: float, harmless: float, weights: Array | None = None
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
    count = len(projections)
    if count < 3:
        return list(range(count))
    weights = np.ones(count) if weights is None else weights
    x = displacement_fields(projections, projections.medoid)
    members = grow(projections, x, densest_half(x, weights), limit, harmless, weights)
    while (
        len(members) >= MIN_BIMODAL_SIZE
        and (part := _split_bimodal(x[members], harmless, weights[members])) is not None
    ):
        members = members[part]
    return sorted(int(i) for i in members)


def grow(
    projections: Projections, x: Array, members: IntArray, limit: float, harmless: float, weights: Array
) -> IntArray:
    """Let all calibrations join `members` (indices) that belong to them, the nearest first: their indices.

    The last step of a `forward_search`, whose parameters the others are; `x` (c, n) are displacement fields.
    """
    count, own = len(projections), projections.bounded_mse
    prior2 = (SPECIMEN_SPREAD_WIDTHS * projections.cameras[0].img_size[0]) ** 2
    while len(members) < count:
        m = len(members)
        d2 = np.sum((x - np.average(x[members], axis=0, weights=weights[members])) ** 2, axis=1)
        outside = np.setdiff1d(np.arange(count), members)
        nearest = outside[np.argmin(d2[outside])]
        noise2 = float(np.mean(own[members]))
        variance = float(np.sum(d2[members])) / max(m - 1, 1)
        # Where noise alone may explain the variance, it is not inflated: few members are no excuse then.
        specimens_differ = variance > SPECIMEN_VARIANCE_RATIO * noise2
        inflation = 1 + ((SMALL_SAMPLE_INFLATION / max(m - 1, 1)) ** 2 if specimens_differ else 0.0)
        beyond_noise = max(variance - noise2, 0.0) * inflation
        degrees = SPECIMEN_SPREAD_MEMBERS + m - 1
        shrunk = (SPECIMEN_SPREAD_MEMBERS * prior2 + (m - 1) * beyond_noise) / degrees
        between = min(MEMBER_SIGMAS**2 * max(beyond_noise, shrunk), limit**2)
        explained = MEMBER_SIGMAS**2 * (own[nearest] + noise2 / m) + between * (1 + 1 / m)
        if d2[nearest] > max(explained, harmless**2):
            break
        members = np.append(members, nearest)
    return members


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


def densest_half(x: Array, weights: Array) -> IntArray:
    """Find the rows with most of the weight that lie closest together around one of them: their indices."""
    d = np.linalg.norm(x[:, None] - x[None], axis=2)
    order = np.argsort(d, axis=1)
    total = np.cumsum(weights[order], axis=1)
    last = np.argmax(total > total[:, -1:] / 2 + 1e-9, axis=1)
    center = np.argmin(np.take_along_axis(d, np.take_along_axis(order, last[:, None], axis=1), axis=1)[:, 0])
    chosen: IntArray = order[center, : last[center] + 1]
    return chosen
