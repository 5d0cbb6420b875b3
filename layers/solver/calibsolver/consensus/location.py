"""Location of a camera's contributors: the camera in the middle of theirs, and the influence of two on it.

The views of a contributor are worth no more than those of the median one, however many points they have.
Every contributor has a specimen of their own, at least MIN_SPREAD_WIDTHS from the location, which bounds
their weight in every direction (random effects). Deviations have Huber's loss (Huber 1964). The location is
the minimum of a convex function, so there is one.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import models
from ..arrays import Array, IntArray, Mask, subsample, symmetric_inverse
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting import prior, resection
from ..fitting.calibration import Calibration
from ..fitting.levenberg_marquardt import residual_rows
from ..fitting.normal_equations import residual_jacobian
from ..fitting.observations import Observations
from ..fitting.resection import MIN_POSE_POINTS
from ..view import View
from .agreement import scaled_metric

MIN_SPREAD_WIDTHS = 0.42 / 1280
"""Standard deviation between specimens, rms over the image / image width: 0.1 % of the focal length."""
HUBER_WIDTHS = 0.75 / 1280
"""Deviation of a specimen from the location, px rms over the image / image width, beyond which it pulls
no harder: 0.18 % of the focal length. Specimens of one product differ by 0.1 to 0.4 %."""
MAX_IRLS_ITERATIONS = 100
IRLS_TOLERANCE_PX = 1e-5
MIN_METRIC = 1e-6
"""Share by which every parameter moves the image at least: invisible directions must not be singular."""
MAX_VIEW_POINTS = 150
MAX_LINEARIZATIONS = 5
STEP_SHARES, MAX_COST_GROWTH = (1.0, 0.5, 0.25, 0.1), 1.01
"""Shares of a step that are tried, and the growth of the cost up to which one is taken."""
MAX_LINEAR_STEP_WIDTHS = 0.05 / 1280
"""Step / image width, rms over the image, from which the views are linearized again."""
MAX_EXACT_CONTRIBUTORS = 8


@dataclass(frozen=True, eq=False)
class Member:
    """Views of one calibration of the camera, with the ids of the calibration and of its contributor.

    Contributors of different families may be the same: only one family is counted.
    """

    id: str
    contributor: str
    views: tuple[View, ...]
    family: str = ""


@dataclass(frozen=True, eq=False)
class Location:
    """Location of contributors: y (p,) intrinsics less the reference's, over `Contributions.scale`.

    Also numbers (c,) of the contributors that have part in it, their Huber weights (c,), at most 1, and the
    deviations (c, p) of their specimens, as `y`.
    """

    y: Array
    numbers: IntArray
    weights: Array
    deviations: Array


@dataclass(frozen=True, eq=False)
class FittedMember:
    """A member and the calibration fitted to its views, in the board's estimated shape."""

    member: Member
    calibration: Calibration


class Contributions:
    """Views of one camera's calibrations, linearized about common intrinsics, by contributor.

    The c calibrations are of one model and image size, `camera` is near all agreeing ones.
    """

    def __init__(self, fitted: Sequence[FittedMember], camera: Camera) -> None:
        self.fitted = fitted
        self.camera = camera
        self.model = models.get(camera.model)
        width = camera.img_size[0]
        self.huber_px = HUBER_WIDTHS * width
        self.owner = number_owners([f.member.contributor for f in fitted])
        k = camera.intrinsics
        self.scale, self.metric = scaled_metric(camera, MIN_METRIC)
        self.between = self.metric / (MIN_SPREAD_WIDTHS * width) ** 2
        with np.errstate(all="ignore"):  # calibrations that do not belong here
            linear = [self._linearize(f) for f in fitted]
        self.information: Array = np.stack([s for s, _, _ in linear])
        self.gradient: Array = np.stack([b for _, b, _ in linear])
        self.sigmas: Array = np.sqrt([cost for _, _, cost in linear])
        """(c,) root of the cost of each calibration's views where they are linearized, in its sigmas."""
        precision = 1 / np.array(
            [np.sum(self._scale_covariance(f.calibration.covariance) * self.metric) for f in fitted]
        )
        self.precision: Array = np.bincount(self.owner, precision).astype(np.float64)
        """(c,) precision of each contributor, 1 / px^2, as mean square error over the image."""
        r, j = prior.residuals(self.model, k, camera.img_size)
        self.prior = (j * self.scale).T @ (j * self.scale), -(j * self.scale).T @ r

    def _scale_covariance(self, covariance: Array) -> Array:
        return covariance / self.scale[:, None] / self.scale

    def _linearize(self, f: FittedMember) -> tuple[Array, Array, float]:
        """Information (p, p) of a calibration's inliers, poses eliminated, half its descent (p,), and cost.

        The noise is that of the calibration's covariance, at least that of the corners.
        """
        pairs = zip(f.member.views, f.calibration.used, strict=True)
        chosen = [thin(view, mask) for view, mask in pairs if mask.sum() >= MIN_POSE_POINTS]
        obs = Observations.of([view for view, _ in chosen])
        poses, _ = resection.resect(self.model, self.camera.intrinsics, obs)
        rows, _ = residual_rows(self.model, self.camera.intrinsics, poses, obs)
        rows = np.where(obs.mask, rows, 0.0)
        rows[:, :, ~np.isfinite(rows.sum(axis=(0, 1, 3)))] = 0.0
        left = residual_jacobian(rows[:-1]) * self.scale
        left *= np.sqrt([[[share]] for _, share in chosen])
        off = rows[-1].transpose(1, 0, 2).reshape(len(left), -1) * np.sqrt([[share] for _, share in chosen])
        s = np.einsum("vnp,vnq->pq", left, left)
        b = -np.einsum("vnp,vn->p", left, off)
        covariance = self._scale_covariance(f.calibration.covariance)
        # With the information that a fit of its own adds at unit noise: the prior's.
        information = prior.information(self.model, self.camera.intrinsics, self.camera.img_size)
        ridge = f.calibration.noise**2 * information * self.scale[:, None] * self.scale
        white = np.sum(symmetric_inverse(s + ridge) * self.metric)
        noise2 = max(float(np.sum(covariance * self.metric) / white), f.calibration.noise**2)
        return s / noise2, b / noise2, float(np.sum(off**2)) / noise2

    def relinearize(self, members: Sequence[int]) -> "Contributions":
        """Linearize again until the location of some calibrations lies where they are linearized."""
        found = self
        for _ in range(MAX_LINEARIZATIONS):
            location = found.locate(members)
            if found.length(location.y) < MAX_LINEAR_STEP_WIDTHS * self.camera.img_size[0]:
                break
            for share in STEP_SHARES:  # along a curved valley the whole step may lead astray
                shorter = Contributions(self.fitted, found.camera_at(replace(location, y=share * location.y)))
                if shorter.sigmas[members].sum() < MAX_COST_GROWTH * found.sigmas[members].sum():
                    break
            else:
                break
            found = shorter
        return found

    def locate(self, members: Sequence[int] | IntArray) -> Location:
        """Locate the contributors of some of the calibrations (indices)."""
        numbers, s, b = self._by_contributor(members)
        weights = np.ones(len(numbers))
        y = np.zeros(len(self.scale))
        known, believed = self.prior
        for _ in range(MAX_IRLS_ITERATIONS):
            weighed = weights[:, None, None] * self.between
            inverse = symmetric_inverse(s + weighed)
            gain = weighed @ inverse
            pull = np.einsum("cpq,cq->p", gain, b - s @ y) + believed - known @ y
            step = symmetric_inverse(np.sum(gain @ s, axis=0) + known) @ pull
            y = y + step
            deviations = np.einsum("cpq,cq->cp", inverse, b - s @ y)
            previous, weights = weights, self.huber_px / np.maximum(self.length(deviations), self.huber_px)
            if self.length(step) < IRLS_TOLERANCE_PX and np.abs(weights - previous).max() < IRLS_TOLERANCE_PX:
                break
        return Location(y, numbers, weights, deviations)

    def _by_contributor(self, members: Sequence[int] | IntArray) -> tuple[IntArray, Array, Array]:
        """Sum information (c, p, p) and gradients (c, p) by contributor, bounded by the median one's."""
        chosen = np.asarray(members, dtype=np.intp)
        numbers, part = np.unique(self.owner[chosen], return_inverse=True)
        s = np.zeros((len(numbers), *self.metric.shape))
        b = np.zeros(s.shape[:2])
        np.add.at(s, part, self.information[chosen])
        np.add.at(b, part, self.gradient[chosen])
        precision = self.precision[numbers]
        share = np.minimum(1.0, np.sort(precision)[(len(precision) - 1) // 2] / precision)
        s, b = s * share[:, None, None], b * share[:, None]
        return np.asarray(numbers, dtype=np.int64), s, b

    def length(self, y: Array) -> Array:
        """Length (...) of scaled intrinsics (..., p): px rms over the image."""
        out: Array = np.sqrt(np.einsum("...p,pq,...q->...", y, self.metric, y))
        return out

    def camera_at(self, location: Location) -> Camera:
        """Camera at a location; raises CalibrationError ``not_believable`` if it is none."""
        k = self.camera.intrinsics + self.scale * location.y
        if not np.isfinite(k).all() or k[0] <= 0 or k[1] <= 0:
            raise CalibrationError("not_believable", "the contributors' cameras have no common one")
        return Camera.from_intrinsics(self.camera.model, k, self.camera.img_size)

    def covariance(self, members: Sequence[int], location: Location) -> Array:
        """Covariance (p, p) of the intrinsics at a location.

        By the noise of the corners, and the differences between contributors beyond it (method of moments).
        """
        _, s, b = self._by_contributor(members)
        w = location.weights[:, None, None]
        gain = w * self.between @ symmetric_inverse(s + w * self.between)
        inverse = symmetric_inverse(np.sum(gain @ s, axis=0) + self.prior[0])
        noise = inverse @ np.sum(gain @ s @ gain.transpose(0, 2, 1), axis=0) @ inverse
        count = len(s)
        if count > 1:
            steps = np.einsum("pq,cqr,cr->cp", inverse, gain, b - s @ location.y)
            found = steps.T @ steps * count / (count - 1)
            expected = float(np.sum(noise * self.metric) / max(np.sum(found * self.metric), 1e-300))
            noise = noise + max(1 - expected, 0.0) * found
        out: Array = noise * self.scale[:, None] * self.scale
        return out

    def majority_spread(self, members: Sequence[int]) -> float:
        """Standard deviation, px rms, of the majority of specimens nearest to the location."""
        away = np.sort(self.length(self.locate(members).deviations))
        majority = away[: len(away) // 2 + 1]
        return float(np.sqrt(np.sum(majority**2) / max(len(majority) - 1, 1)))

    def leave_out_influence(self, group: Sequence[int], regroup: Callable[[IntArray], IntArray]) -> float:
        """Largest shift of the location of `group` when one or two contributors are left out, px rms.

        `regroup` decides again which of the remaining calibrations (indices) agree. Infinite if no
        contributor is left. Of many contributors those with most influence are left out.
        """
        whole = self.locate(group)
        if len(whole.numbers) < 3:
            return np.inf
        pull = self.length(whole.deviations) * whole.weights
        candidates = whole.numbers[np.argsort(-pull, kind="stable")][:MAX_EXACT_CONTRIBUTORS]
        largest = 0.0
        members = np.arange(len(self.owner))
        for left_out in itertools.chain(
            itertools.combinations(candidates, 1), itertools.combinations(candidates, 2)
        ):
            rest = members[~np.isin(self.owner, left_out)]
            largest = max(largest, float(self.length(self.locate(regroup(rest)).y - whole.y)))
        return largest


def number_owners(names: Sequence[str]) -> IntArray:
    """Numbers (c,) of names, in the order of their first occurrence, so that no result depends on a name."""
    numbers = {name: i for i, name in enumerate(dict.fromkeys(names))}
    return np.array([numbers[name] for name in names], dtype=np.int64)


def thin(view: View, used: Mask) -> tuple[View, float]:
    """At most MAX_VIEW_POINTS of the points used, evenly chosen, and how many each stands for."""
    taken = np.flatnonzero(used)
    chosen = taken[subsample(len(taken), MAX_VIEW_POINTS)]
    return view.subset(chosen), len(taken) / len(chosen)
