"""Agreement of calibrations of one camera: each is compared with the prediction of the others.

A calibration agrees with others if two ratios are small. `d` is the difference of its intrinsics from theirs,
`S` the information of its own corners, `C` the sum of the covariances of both and of the difference between
two specimens:

* predictive ratio, d' S d / trace(S C): the squared reprojection error that the others' camera adds to its
  corners (poses fitted again, to second order) over its expectation;
* distance ratio, d' C^-1 d / p: the mean square standardised difference.

The first finds cameras that the corners contradict, however vague both are. The second finds small
differences of precise calibrations, relative to the spread of the other members' specimens. The camera of the
others is a random-effects mean with Huber weights (DerSimonian & Laird 1986; Huber 1964). A calibration of
few or poor views agrees with everything, and weighs next to nothing.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import models, rotation
from ..arrays import Array, IntArray, Mask, symmetric_inverse, whitening
from ..camera import Camera, pixel_grid
from ..fitting.calibration import Calibration
from ..fitting.uncertainty import image_error_metric, projection_jacobian_rotation_free

COMPARISON_GRID = (12, 9)
MIN_SHARED_IMAGE = 0.5
MAX_PREDICTIVE_RATIO = 5.0
MAX_DISTANCE_RATIO = 5.0
"""Limits of the ratios, the second if specimens differ by SPECIMEN_SPREAD_WIDTHS."""
MAX_NEIGHBOUR_DISAGREEMENT = 0.5
"""Disagreement up to which a group may start from two calibrations, so that none is a bridge."""
SPECIMEN_SPREAD_WIDTHS = 0.00083
"""Standard deviation of the difference of two specimens, rms over the image / image width."""
SPECIMEN_DIRECTIONS = 3
"""Directions in which specimens differ: focal length and principal point."""
SPREAD_MEMBERS, MAX_SPREAD_RATIO = 2.0, 6.0
"""Members that SPECIMEN_SPREAD_WIDTHS is worth; largest variance / its square that a group may show."""
MAX_PULL_SIGMAS = 1.5
"""Standardised distance from the mean beyond which a contributor pulls no harder."""
MIN_IMAGE_SHARE = 1e-4
"""Share by which every parameter moves the image at least: no direction is exempt."""
MAX_MEAN_ITERATIONS = 20
MAX_ROUNDS = 12
MAX_STARTS = 4


@dataclass(frozen=True, eq=False)
class Estimates:
    """Intrinsics that calibrations of one camera state.

    Attributes
    ----------
    y
        (c, p) intrinsics less the reference's, each over the change that moves the image by 1 px rms.
    covariance, information
        (c, p, p) of `y`; the information at unit noise, px^-2.
    specimens
        (p, p) covariance of the difference of two specimens.
    owner
        (c,) number of the contributor, whose calibrations show one specimen.
    """

    y: Array
    covariance: Array
    information: Array
    specimens: Array
    owner: IntArray

    @classmethod
    def of(cls, calibrations: Sequence[Calibration], owner: IntArray, reference: Camera) -> "Estimates":
        """Scale the intrinsics of calibrations of one model and image size about a reference camera."""
        k, width = reference.intrinsics, reference.img_size[0]
        scale, metric = scaled_metric(reference, MIN_IMAGE_SHARE)
        specimens = symmetric_inverse(metric) * (SPECIMEN_SPREAD_WIDTHS * width) ** 2 / len(k)
        y = np.array([(c.camera.intrinsics - k) / scale for c in calibrations])
        covariance = np.array([c.covariance / scale[:, None] / scale for c in calibrations])
        unit = np.array([c.information * c.noise**2 * scale[:, None] * scale for c in calibrations])
        return cls(y, covariance, unit, specimens, owner)

    def disagreement(self, members: IntArray) -> Array:
        """Disagreement (c,) of all calibrations with the `members` (indices) of other contributors.

        Up to 1 a calibration agrees. If the members have one contributor, each calibration counts as one.
        Infinite if there is no other.
        """
        numbers, part = np.unique(self.owner[members], return_inverse=True)
        if len(numbers) == 1 < len(members):
            return replace(self, owner=np.arange(len(self.y))).disagreement(members)
        y, precision = self._by_contributor(members, part, len(numbers))
        weights = self._huber_weights(y, precision)
        weighed = weights[:, None, None] * precision
        pulls = np.einsum("cpq,cq->cp", weighed, y)
        # Without the contributor of each calibration
        place = np.searchsorted(numbers, self.owner).clip(0, len(numbers) - 1)
        own = numbers[place] == self.owner
        total = weighed.sum(axis=0) - own[:, None, None] * weighed[place]
        pull = pulls.sum(axis=0) - own[:, None] * pulls[place]
        alone = own & (len(numbers) == 1)
        total[alone] = np.eye(total.shape[1])
        others = symmetric_inverse(total)
        ratio, distance = self._ratios(np.einsum("cpq,cq->cp", others, pull), others)
        expected = self._expected_distances(distance, members, part)
        out = np.maximum(ratio / MAX_PREDICTIVE_RATIO, distance / (MAX_DISTANCE_RATIO * expected))
        return np.where(alone, np.inf, out)

    def pairwise(self) -> Array:
        """Disagreement (c, c) of each calibration (row) with each other one (column)."""
        columns = []
        for y, covariance in zip(self.y, self.covariance, strict=True):
            ratio, distance = self._ratios(np.broadcast_to(y, self.y.shape), covariance)
            columns.append(np.maximum(ratio / MAX_PREDICTIVE_RATIO, distance / MAX_DISTANCE_RATIO))
        return np.stack(columns, axis=1)

    def _ratios(self, y: Array, covariance: Array) -> tuple[Array, Array]:
        """Predictive and distance ratios (c,) under cameras `y` (c, p) of a `covariance` ((c,) p, p)."""
        d = y - self.y
        total = self.covariance + covariance + self.specimens
        increase = np.einsum("cp,cpq,cq->c", d, self.information, d)
        expected = np.sum(self.information * total, axis=(1, 2))
        distance = np.sum(np.einsum("cpq,cp->cq", whitening(total), d) ** 2, axis=1) / d.shape[1]
        return increase / np.maximum(expected, 1e-300), distance

    def _expected_distances(self, distance: Array, members: IntArray, part: IntArray) -> Array:
        """Expected distance ratio (c,) given the spread of the other members' specimens, at least 1.

        Their variance / that of SPECIMEN_SPREAD_WIDTHS counts as far as specimens are part of the covariance.
        Each contributor counts once, and the median decides: a distant minority is not a spread.
        """
        size = self.y.shape[1]
        own_share = (
            np.sum(symmetric_inverse(self.covariance + self.specimens) * self.specimens, axis=(1, 2)) / size
        )
        excess = (distance - (1 - own_share)) * size / SPECIMEN_DIRECTIONS
        excess = np.clip(excess, 0, MAX_SPREAD_RATIO * own_share)
        numbers = np.unique(self.owner[members])
        count = np.bincount(part)
        excess = np.bincount(part, excess[members]) / count
        share = np.bincount(part, own_share[members]) / count
        spread = np.empty(len(self.y))
        for owner in np.unique(self.owner):
            other = numbers != owner
            total = other.sum()
            middle = np.median(excess[other]) if total else 0.0
            ratio = (SPREAD_MEMBERS + total * middle) / (SPREAD_MEMBERS + share[other].sum())
            spread[self.owner == owner] = np.clip(ratio, 1, MAX_SPREAD_RATIO)
        expected: Array = 1 + own_share * (spread - 1)
        return expected

    def _by_contributor(self, members: IntArray, part: IntArray, count: int) -> tuple[Array, Array]:
        """Mean (n, p) of each contributor and its precision (n, p, p) as an estimate of the product."""
        claim = symmetric_inverse(self.covariance[members])
        size = self.y.shape[1]
        information, pull = np.zeros((count, size, size)), np.zeros((count, size))
        np.add.at(information, part, claim)
        np.add.at(pull, part, np.einsum("cpq,cq->cp", claim, self.y[members]))
        covariance = symmetric_inverse(information)
        y = np.einsum("npq,nq->np", covariance, pull)
        return y, symmetric_inverse(covariance + self.specimens / 2)

    def _huber_weights(self, y: Array, precision: Array) -> Array:
        """Huber weights (n,) of contributors about their robust mean."""
        weights = np.ones(len(y))
        for _ in range(MAX_MEAN_ITERATIONS):
            weighed = weights[:, None, None] * precision
            pull = np.einsum("npq,nq->p", weighed, y)
            away = y - symmetric_inverse(weighed.sum(axis=0)) @ pull
            distance = np.sqrt(np.einsum("np,npq,nq->n", away, precision, away) / y.shape[1])
            before, weights = weights, np.minimum(1.0, MAX_PULL_SIGMAS / np.maximum(distance, 1e-12))
            if np.abs(weights - before).max() < 1e-3:
                break
        return weights


def scaled_metric(camera: Camera, least: float) -> tuple[Array, Array]:
    """Changes (p,) of the intrinsics that move the image by 1 px rms, and the error metric (p, p) over them.

    Every parameter counts as if it moved the image by at least the share `least`.
    """
    model, k = models.get(camera.model), camera.intrinsics
    d = projection_jacobian_rotation_free(model, k, camera.img_size, COMPARISON_GRID)
    metric = image_error_metric(d)
    scale = 1 / np.sqrt(np.maximum(np.diagonal(metric), 1e-300))
    return scale, metric * scale[:, None] * scale + least * np.eye(len(k))


def split_into_groups(estimates: Estimates, weights: Array) -> list[list[int]]:
    """Groups in which each calibration agrees with the others, the heaviest by `weights` (c,) first."""
    pairwise = estimates.pairwise()
    agree = np.maximum(pairwise, pairwise.T) <= MAX_NEIGHBOUR_DISAGREEMENT
    left, groups = np.arange(len(weights)), []
    while left.size:
        group = _largest_group(estimates, left, agree, weights)
        groups.append([int(i) for i in group])
        left = np.setdiff1d(left, group)
    return sorted(groups, key=lambda group: -_total(weights[group]))


def _largest_group(estimates: Estimates, among: IntArray, agree: Mask, weights: Array) -> IntArray:
    """Heaviest group among calibrations (indices); of equals the one that agrees best."""
    near = agree[np.ix_(among, among)] | np.eye(len(among), dtype=bool)
    sizes = np.round(near @ weights[among], 9)
    starts: dict[tuple[int, ...], None] = {}
    for i in np.argsort(-sizes, kind="stable"):
        if len(starts) >= MAX_STARTS:
            break
        starts[tuple(among[near[i]].tolist())] = None
    candidates = [settle(estimates, np.array(start, dtype=np.int64), among) for start in starts]
    return max(candidates, key=lambda group: (_total(weights[group]), -_discord(estimates, group)))


def settle(estimates: Estimates, start: IntArray, among: IntArray) -> IntArray:
    """Let a group take in and drop calibrations `among` all (indices) until each agrees with the others.

    If that never comes to rest, those that agree least are dropped one by one.
    """
    group = start
    for _ in range(MAX_ROUNDS):
        following = among[estimates.disagreement(group)[among] <= 1]
        if np.array_equal(following, group):
            return group
        if following.size < 2:
            break
        group = following
    while len(group) > 1:
        away = estimates.disagreement(group)[group]
        worst = int(np.argmax(away))
        if away[worst] <= 1:
            break
        group = np.delete(group, worst)
    return group


def _discord(estimates: Estimates, group: IntArray) -> float:
    return float(np.mean(estimates.disagreement(group)[group])) if len(group) > 1 else 0.0


def _total(weights: Array) -> float:
    """Sum of weights, rounded so that equal sums compare equal."""
    return round(float(weights.sum()), 9)


def difference(one: Camera, other: Camera) -> float:
    """Difference between the projections of two cameras, px rms over the image."""
    return float(differences([one, other])[0, 1])


def differences(cameras: Sequence[Camera]) -> Array:
    """Differences (c, c) between projections of cameras of one image size, px rms over the image.

    After the best rotation (Kabsch 1976), which every pose absorbs: the remaining angle times the local
    magnification. Infinite if two cameras share less than half of the image.
    """
    q = pixel_grid(cameras[0].img_size, COMPARISON_GRID).reshape(2, -1)
    sampled = [_rays(camera, q) for camera in cameras]
    rays, magnification = (np.stack(parts) for parts in zip(*sampled, strict=True))
    defined = magnification > 0
    both = defined[:, None, :] & defined[None, :, :]
    count = both.sum(axis=2)
    r = rotation.nearest(np.einsum("anb,cnd->acbd", rays, rays))  # ray of a ~ r @ ray of c
    out = np.empty((len(cameras), len(cameras)))
    for a in range(len(cameras)):
        aligned = np.einsum("cij,cnj->cni", r[a], rays)
        angle2 = np.sum((rays[a] - aligned) ** 2, axis=2)
        square = angle2 * magnification[a] ** 2 * both[a]
        out[a] = np.sqrt(square.sum(axis=1) / np.maximum(count[a], 1))
    out[count < MIN_SHARED_IMAGE * q.shape[1]] = np.inf
    np.fill_diagonal(out, 0.0)
    return out


def _rays(camera: Camera, q: Array) -> tuple[Array, Array]:
    """Unit rays (n, 3) of pixels, and magnification (n,), px per radian; 0 where there is no ray."""
    model, k = models.get(camera.model), camera.intrinsics
    v = model.unproject(k, q)
    with np.errstate(all="ignore"):
        _, _, by_p = model.jacobian(k, v)
        # Area magnification px^2 per steradian: the Jacobian is 0 along the ray.
        g = np.einsum("ian,ibn->nab", by_p, by_p)
        magnification = np.sqrt(np.sqrt(np.maximum(np.linalg.det(g), 0)))
    defined = np.isfinite(v[0]) & np.isfinite(magnification)
    return np.where(defined, v, 0.0).T, np.where(defined, magnification, 0.0)
