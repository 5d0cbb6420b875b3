"""Pooled fit of calibrations that agree: to all views, or to the location of their contributors."""

from collections.abc import Callable, Sequence

import numpy as np

from ..arrays import Array, IntArray, Mask, frozen, symmetric_inverse
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.fit import fit, refine
from ..fitting.resection import MIN_POSE_POINTS, reprojection_score
from ..rotation import matrix
from .location import Contributions, FittedMember

FOLDS = 5


def fit_views(group: Sequence[FittedMember], img_size: tuple[int, int], model: str) -> Calibration:
    """Fit one camera to the views of all members of a group; raises as `fit` does."""
    if len(group) == 1:
        return group[0].calibration  # which is just that
    return fit([view for f in group for view in f.member.views], img_size, model, board_shape=False)


def fit_location(group: Sequence[int], of: Contributions) -> Calibration:
    """Pooled fit: the camera at the location of a group's contributors."""
    location = of.locate(group)
    return describe(of.camera_at(location), [of.fitted[i] for i in group], of.covariance(group, location))


def describe(camera: Camera, group: Sequence[FittedMember], covariance: Array) -> Calibration:
    """Describe a camera by the views of a group: poses by their inliers, errors over all points."""
    views = [view for f in group for view in f.member.views]
    used = [mask for f in group for mask in f.calibration.used]
    shown = [
        view.subset(mask) if mask.sum() >= MIN_POSE_POINTS else view
        for view, mask in zip(views, used, strict=True)
    ]
    posed = reprojection_score(camera, shown).poses
    limit = float(np.hypot(*camera.img_size))
    residuals = [
        view.image_points - camera.project(view.object_points @ matrix(pose[:3]).T + pose[3:])
        for view, pose in zip(views, posed, strict=True)
    ]
    lengths = [np.fmin(np.linalg.norm(e, axis=1), limit) for e in residuals]  # of NaN the limit
    square = [float(np.sum(e**2)) for e in lengths]
    points = [len(e) for e in lengths]
    noise = np.sqrt(np.mean([f.calibration.noise**2 for f in group]))
    weights = [sum(map(len, f.member.views)) for f in group]
    return Calibration(
        camera=camera,
        poses=frozen(posed),
        avg_reprojection_error=float(np.sqrt(sum(square) / sum(points))),
        view_errors=frozen(np.sqrt(np.divide(square, points))),
        covariance=frozen(covariance),
        information=frozen(symmetric_inverse(covariance)),
        noise=float(noise),
        inflation=float(np.average([f.calibration.inflation for f in group], weights=weights)),
        residuals=tuple(frozen(e) for e in residuals),
        used=tuple(used),
        prior_used=any(f.calibration.prior_used for f in group),
    )


def cross_validate_views(group: Sequence[FittedMember], pooled: Camera) -> Array:
    """Rms (m,), px, of each member's views under intrinsics fitted without it, from the `pooled` camera.

    In at most FOLDS fits, so that a large group takes no longer. Infinite if the others give no fit.
    """
    views = [view for f in group for view in f.member.views]
    owner = np.repeat(np.arange(len(group)), [len(f.member.views) for f in group])
    poses = reprojection_score(pooled, views).poses

    def fit_without(out: Mask) -> Camera:
        others = np.flatnonzero(~out[owner])
        return refine([views[i] for i in others], pooled, poses[others]).camera

    return _held_out_errors(group, np.arange(len(group)), fit_without)


def cross_validate_contributors(group: Sequence[int], of: Contributions) -> Array:
    """Rms (m,), px, of each member's views under the location of other contributors.

    Of a single contributor, its calibrations are left out in turn.
    """
    members: IntArray = np.asarray(group, dtype=np.int64)
    numbers, part = np.unique(of.owner[members], return_inverse=True)
    if len(numbers) < 2:
        part = np.arange(len(members))
    return _held_out_errors(
        [of.fitted[i] for i in group], part, lambda out: of.camera_at(of.locate(members[~out]))
    )


def _held_out_errors(
    group: Sequence[FittedMember], part: IntArray, fit_without: Callable[[Mask], Camera]
) -> Array:
    errors = np.full(len(group), np.inf)
    for fold in range(min(FOLDS, int(part.max()) + 1)):
        out = part % FOLDS == fold
        try:
            camera = fit_without(out)
        except CalibrationError:
            continue
        for i in np.flatnonzero(out).tolist():
            errors[i] = reprojection_score(camera, group[i].member.views).rms
    return errors
