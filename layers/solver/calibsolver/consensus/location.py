"""Location of a camera's contributors, the projection in their middle, and the influence of two on it.

Every contributor is one displacement field over the image, whatever the number of its points: the mean of its
calibrations'. The location is their M-estimate with Huber's loss (Huber 1964): the mean of those that lie
near each other, while one far away pulls no harder than one at a distance of `HUBER_WIDTHS`. It is the
minimum of a convex function, so there is one, and it moves little when any contributor moves a little.
"""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .. import models, rotation
from ..arrays import Array, IntArray, Mask
from ..camera import Camera, pixel_grid
from ..errors import CalibrationError
from .agreement import COMPARISON_GRID, Projections, densest_half

HUBER_WIDTHS = 1 / 1280
"""Distance from the location / image width beyond which a contributor pulls no harder: what 0.25 % of the
focal length are over the image, and specimens of one product differ by 0.1 to 0.4 %."""
MAX_IRLS_ITERATIONS = 60
"""Iterations of the M-estimate."""
IRLS_TOLERANCE_PX = 1e-5
"""Change of the field below which the M-estimate has settled."""
MAX_EXACT_CONTRIBUTORS = 8
"""Contributors, those with most influence, of whom each two are left out with everything decided anew."""
MAX_FIT_ITERATIONS = 10
MIN_FIT_SINGULAR_VALUE = 1e-7
"""Ratio to the largest singular value below which a direction of the intrinsics does not move the field."""


@dataclass(frozen=True, eq=False)
class Location:
    """Location of contributors.

    Attributes
    ----------
    field
        (n, 2) px, displacement of each pixel's ray from that of the reference; NaN where nobody has a ray.
    weights
        (c,) weights of the contributors, at most 1; 0 of those who have no part in it.
    distances
        (c,) px rms over the image, from each contributor to the location.
    """

    field: Array
    weights: Array
    distances: Array


class ContributorFields:
    """Displacement fields of calibrations from the projections of one of them, by contributor.

    Parameters
    ----------
    projections
        Of the c calibrations.
    contributors
        (c,) names.
    reference
        Index of the calibration in whose image displacements are measured.
    """

    def __init__(self, projections: Projections, contributors: Sequence[str], reference: int) -> None:
        self.projections = projections
        self.camera = projections.cameras[reference]
        names, owner = np.unique(np.asarray(contributors), return_inverse=True)
        self.names: list[str] = names.tolist()
        self.owner: IntArray = np.asarray(owner, dtype=np.int64)
        self.huber_px = HUBER_WIDTHS * self.camera.img_size[0]
        self.seen: Mask = projections.defined * projections.defined[reference]
        self.fields = _displacements(projections, reference, self.seen)

    def locate(self, members: Sequence[int] | IntArray) -> Location:
        """Locate the contributors of some of the calibrations."""
        x, seen, noise2, present = self._by_contributor(np.asarray(members, dtype=np.intp))
        base = self.huber_px**2 / (self.huber_px**2 + noise2)
        base = np.minimum(base, np.sort(base)[(len(base) - 1) // 2])
        mean, weights = _average(x, seen, base), base
        for _ in range(MAX_IRLS_ITERATIONS):
            distances = _rms(x - mean, seen)
            weights = base * self.huber_px / np.maximum(distances, self.huber_px)
            previous, mean = mean, _average(x, seen, weights)
            if np.abs(mean - previous).max() < IRLS_TOLERANCE_PX:
                break
        field = np.where(np.asarray(seen.any(axis=0))[:, None], mean, np.nan)
        count = len(self.names)
        all_weights, all_distances = np.zeros(count), np.full(count, np.nan)
        all_weights[present], all_distances[present] = weights, _rms(x - mean, seen)
        return Location(field, all_weights, all_distances)

    def _by_contributor(self, members: IntArray) -> tuple[Array, Mask, Array, IntArray]:
        """Average by contributor: fields (c, n, 2), pixels seen (c, n), noise (c,) px^2, numbers (c,)."""
        present = np.unique(self.owner[members])
        fields, masks, noise2 = [], [], []
        for number in present:
            own = members[self.owner[members] == number]
            masks.append(self.seen[own].any(axis=0))
            fields.append(_average(self.fields[own], self.seen[own], np.ones(len(own))))
            noise2.append(float(np.mean(self.projections.mse[own])) / len(own))
        return np.stack(fields), np.stack(masks), np.array(noise2), present

    def residuals(self, members: Sequence[int] | IntArray, location: Location) -> Array:
        """Fields (c, n, 2) of the contributors less the location, px; 0 where one has no ray or no part."""
        out = np.zeros((len(self.names), *self.fields.shape[1:]))
        x, seen, _, present = self._by_contributor(np.asarray(members, dtype=np.intp))
        out[present] = np.where(seen[:, :, None], x - np.nan_to_num(location.field), 0.0)
        return out

    def majority_spread(self, group: Sequence[int]) -> float:
        """Compute the standard deviation, px rms, of the densest majority of a group's contributors."""
        x, _, _, _ = self._by_contributor(np.asarray(group, dtype=np.intp))
        flat = x.reshape(len(x), -1) / np.sqrt(x.shape[1])
        members = flat[densest_half(flat, np.ones(len(x)))]
        square = np.sum((members - members.mean(axis=0)) ** 2) / max(len(members) - 1, 1)
        return float(np.sqrt(square))

    def leave_out_influence(
        self, group: Sequence[int], regroup: Callable[[IntArray], IntArray]
    ) -> tuple[float, float]:
        """Largest shifts of the location of `group` when one, and when two contributors are left out, px rms.

        `regroup` decides anew which of the remaining calibrations (indices) agree with those of the group.
        Infinite where nobody is left. Of many contributors those are left out that have most influence.
        """
        whole = self.locate(group)
        pull = np.nan_to_num(whole.weights * whole.distances)
        inside = np.flatnonzero(whole.weights > 0)
        if len(inside) < 3:
            return np.inf, np.inf
        candidates = inside[np.argsort(-pull[inside], kind="stable")][:MAX_EXACT_CONTRIBUTORS]
        one, two = 0.0, 0.0
        everybody = np.arange(len(self.owner))
        for left_out in itertools.chain(
            itertools.combinations(candidates, 1), itertools.combinations(candidates, 2)
        ):
            rest = everybody[~np.isin(self.owner, left_out)]
            shift = field_distance(whole.field, self.locate(regroup(rest)).field)
            one = max(one, shift) if len(left_out) == 1 else one
            two = max(two, shift)
        return one, two

    def fit(self, location: Location) -> tuple[Camera, float]:
        """Fit a camera of the reference's model to a location: the camera, and its distance, px rms.

        Least squares over the pixels of the grid, a turn of the camera frame free (Gauss-Newton). Raises
        CalibrationError ``not_believable`` where it ends nowhere.
        """
        model, k = models.get(self.camera.model), self.camera.intrinsics
        q = pixel_grid(self.camera.img_size, COMPARISON_GRID).reshape(2, -1)
        rays = model.unproject(k, q + np.nan_to_num(location.field).T)
        known = np.isfinite(rays).all(axis=0) & np.isfinite(location.field).all(axis=1)
        q, rays, turn = q[:, known], rays[:, known], np.eye(3)
        error = np.inf
        with np.errstate(all="ignore"):  # what runs away is refused below
            for _ in range(MAX_FIT_ITERATIONS):
                p = turn @ rays
                there, by_k, by_p = model.jacobian(k, p)
                off = there - q
                previous, error = error, float(np.sqrt(np.mean(np.sum(off**2, axis=0))))
                if not np.isfinite(error) or abs(previous - error) < IRLS_TOLERANCE_PX:
                    break
                turned = np.cross(p.T[:, None, :], by_p.transpose(2, 1, 0))  # (n, 2, 3)
                rows = np.concatenate([by_k.transpose(2, 1, 0), turned], axis=2).reshape(-1, len(k) + 3)
                scale = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
                step = np.linalg.lstsq(rows / scale, -off.T.ravel(), rcond=MIN_FIT_SINGULAR_VALUE)[0] / scale
                k, turn = k + step[: len(k)], rotation.matrix(step[len(k) :]) @ turn
        if not (np.isfinite(error) and np.isfinite(k).all()):
            raise CalibrationError("not_believable", "the contributors' cameras have no common one")
        return Camera.from_intrinsics(self.camera.model, k, self.camera.img_size), error


def field_distance(one: Array, other: Array) -> float:
    """Rms distance, px, of two fields (n, 2) over the pixels that both have."""
    square = np.sum((one - other) ** 2, axis=1)
    both = np.isfinite(square)
    return float(np.sqrt(np.mean(square[both]))) if both.any() else float(np.inf)


def _average(x: Array, seen: Mask, weights: Array) -> Array:
    """Weighted mean (n, 2) of fields (c, n, 2) over those that see a pixel; 0 where none does."""
    w = seen * weights[:, None]
    total = w.sum(axis=0)
    mean: Array = np.einsum("cn,cna->na", w, x) / np.maximum(total, 1e-300)[:, None]
    return mean


def _rms(x: Array, seen: Mask) -> Array:
    """Rms (c,) of fields (c, n, 2) over the pixels seen."""
    square = np.sum(x**2, axis=2) * seen
    rms: Array = np.sqrt(square.sum(axis=1) / np.maximum(seen.sum(axis=1), 1))
    return rms


def _displacements(projections: Projections, reference: int, seen: Mask) -> Array:
    """Displacements (c, n, 2), px, of the rays of pixels as the reference's camera sees them; 0 where unseen.

    The rotation of the camera frame that makes it least is removed from each.
    """
    v, base = projections.rays, projections.cameras[reference]
    model, k = models.get(base.model), base.intrinsics
    with np.errstate(all="ignore"):
        _, _, by_p = model.jacobian(k, v[reference].T)
    b = np.where(projections.defined[reference][:, None, None], by_p.transpose(2, 1, 0), 0.0)  # (n, 2, 3)
    shared = v * seen[:, :, None]
    r = rotation.nearest(np.einsum("nb,cnd->cbd", v[reference], shared))
    x = np.einsum("nij,cnj->cni", b, (np.einsum("cij,cnj->cni", r, v) - v[reference]) * seen[:, :, None])
    by_rotation = np.cross(v[reference][:, None, :], b)  # b . (w x v) = w . (v x b)
    for one, mask in zip(x, seen, strict=True):
        turns = by_rotation[mask].reshape(-1, 3)
        flat = one[mask].ravel()
        one[mask] = (flat - turns @ np.linalg.lstsq(turns, flat, rcond=None)[0]).reshape(-1, 2)
    out: Array = x
    return out
