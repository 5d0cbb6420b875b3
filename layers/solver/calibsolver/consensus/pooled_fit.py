"""Pooled fit of calibrations that agree: to all views, or to the location of their contributors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .. import models
from ..arrays import Array, IntArray, Mask, frozen
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.fit import fit, refine
from ..fitting.resection import MIN_POSE_POINTS, reprojection_score
from ..fitting.uncertainty import projection_jacobian_rotation_free
from ..rotation import matrix
from ..view import View
from .agreement import COMPARISON_GRID
from .location import ContributorFields, Location

FOLDS = 5
"""Parts of a group that are left out in turn."""
MIN_COVARIANCE_SINGULAR_VALUE = 1e-4
"""Ratio to the largest singular value below which a direction of the intrinsics is not told by fields."""


@dataclass(frozen=True, eq=False)
class Member:
    """Views of one calibration of the camera, with the ids of the calibration and of its contributor.

    Contributors of different families may be the same: where they are counted, one family counts.
    """

    id: str
    contributor: str
    views: tuple[View, ...]
    family: str = ""


@dataclass(frozen=True, eq=False)
class Fitted:
    """A member and the calibration fitted to its views."""

    member: Member
    calibration: Calibration


def fit_views(group: Sequence[Fitted], img_size: tuple[int, int], model: str) -> Calibration:
    """Fit one camera to the views of all members of a group; raises as `fit` does."""
    return fit([view for f in group for view in f.member.views], img_size, model)


def fit_location(
    fitted: Sequence[Fitted], group: Sequence[int], fields: ContributorFields, location: Location
) -> tuple[Calibration, float]:
    """Fit one camera to the location of a group's contributors: the calibration, and its distance, px rms.

    Its covariance holds what the noise of the corners, and the differences between contributors beyond it,
    leave open of the location.
    """
    camera, distance = fields.fit(location)
    members = [fitted[i] for i in group]
    covariance = _location_covariance(fitted, group, fields, location)
    return describe(camera, members, covariance), distance


def _location_covariance(
    fitted: Sequence[Fitted], group: Sequence[int], fields: ContributorFields, location: Location
) -> Array:
    """Covariance (p, p) of the location, by random effects of contributors and the method of moments."""
    owners = fields.owner[list(group)]
    w = location.weights / location.weights.sum()
    noise = np.zeros((len(fitted[group[0]].calibration.covariance),) * 2)
    for number in np.unique(owners):
        own = [fitted[i].calibration.covariance for i, o in zip(group, owners, strict=True) if o == number]
        noise += w[number] ** 2 * np.mean(own, axis=0) / len(own)
    count = int((w > 0).sum())
    if count < 2:
        return noise
    model, k = models.get(fields.camera.model), fields.camera.intrinsics
    d = projection_jacobian_rotation_free(model, k, fields.camera.img_size, COMPARISON_GRID)
    known = np.isfinite(d).all(axis=(1, 2))
    flat = d[known].reshape(-1, len(k))
    scale = np.maximum(np.linalg.norm(flat, axis=0), 1e-300)
    x = w[:, None] * fields.residuals(group, location)[:, known].reshape(len(w), -1)
    step = np.linalg.lstsq(flat / scale, x.T, rcond=MIN_COVARIANCE_SINGULAR_VALUE)[0].T / scale
    between = step.T @ step * count / (count - 1)
    expected, found = (float(np.einsum("np,pq,nq->", flat, c, flat)) for c in (noise, between))
    beyond_noise = max(1 - expected / max(found, 1e-300), 0.0)
    out: Array = noise + beyond_noise * between
    return out


def describe(camera: Camera, group: Sequence[Fitted], covariance: Array) -> Calibration:
    """Describe a camera by the views of a group: poses by their inliers, errors over all points."""
    views = [view for f in group for view in f.member.views]
    used = [mask for f in group for mask in f.calibration.used]
    posed = reprojection_score(camera, [_inliers(v, mask) for v, mask in zip(views, used, strict=True)]).poses
    limit = float(np.hypot(*camera.img_size))
    residuals = []
    for view, pose in zip(views, posed, strict=True):
        q = camera.project(view.object_points @ matrix(pose[:3]).T + pose[3:])
        length = np.linalg.norm(q - view.image_points, axis=1)
        residuals.append(np.where(np.isfinite(length), np.minimum(length, limit), limit))
    square = [float(np.sum(e**2)) for e in residuals]
    points = [len(e) for e in residuals]
    noise = np.sqrt(np.mean([f.calibration.noise**2 for f in group]))
    return Calibration(
        camera=camera,
        poses=frozen(posed),
        avg_reprojection_error=float(np.sqrt(sum(square) / sum(points))),
        view_errors=frozen(np.sqrt(np.divide(square, points))),
        covariance=frozen(covariance),
        noise=float(noise),
        residuals=tuple(frozen(e) for e in residuals),
        used=tuple(used),
        prior_used=any(f.calibration.prior_used for f in group),
    )


def _inliers(view: View, used: Mask) -> View:
    """Select the inliers of a view, where they are enough for a pose; else the view."""
    if used.sum() < MIN_POSE_POINTS:
        return view
    return View(view.object_points[used], view.image_points[used])


def cross_validate_views(group: Sequence[Fitted], pooled: Camera) -> Array:
    """Rms (m,), px, of each member's views under intrinsics fitted without it, the poses alone fitted anew.

    At most FOLDS fits, each from where that of all, `pooled`, ended: with a member up to a fifth of the group
    is left out, so that a large group takes no longer. Infinite where the others alone give no fit.
    """
    errors = np.full(len(group), np.inf)
    views = [view for f in group for view in f.member.views]
    owner = np.repeat(np.arange(len(group)), [len(f.member.views) for f in group])
    poses = reprojection_score(pooled, views).poses
    for fold in range(min(FOLDS, len(group))):
        held_out = range(fold, len(group), FOLDS)
        others = np.flatnonzero(~np.isin(owner, held_out))
        try:
            camera = refine([views[i] for i in others], pooled, poses[others]).camera
        except CalibrationError:
            continue
        for i in held_out:
            errors[i] = reprojection_score(camera, group[i].member.views).rms
    return errors


def cross_validate_contributors(
    fitted: Sequence[Fitted], group: Sequence[int], fields: ContributorFields
) -> Array:
    """Rms (m,), px, of each member's views under the location of the other contributors, as above.

    With a contributor up to a fifth of them is left out; of a single one, its calibrations in turn.
    """
    members: IntArray = np.asarray(group, dtype=np.int64)
    numbers, part = np.unique(fields.owner[members], return_inverse=True)
    if len(numbers) < 2:
        part = np.arange(len(members))
    errors = np.full(len(members), np.inf)
    for fold in range(min(FOLDS, int(part.max()) + 1)):
        out = part % FOLDS == fold
        try:
            camera, _ = fields.fit(fields.locate(members[~out]))
        except CalibrationError:
            continue
        for i in np.flatnonzero(out):
            errors[i] = reprojection_score(camera, fitted[members[i]].member.views).rms
    return errors
