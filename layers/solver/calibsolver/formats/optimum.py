"""Cameras at the least-squares optimum of the points that they were fitted to, where a tool expects them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .. import models
from ..arrays import Array, Mask
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting import resection
from ..fitting.fit import FREE, refine
from ..fitting.levenberg_marquardt import Problem
from ..fitting.observations import Observations
from ..view import View
from .base import Conversion, ExportSource
from .convert import compare

MIN_USED_POINTS = 6
"""Points of a view with which it counts."""


def at_optimum(source: ExportSource, conversion: Conversion) -> Conversion:
    """Return a conversion whose camera is the least-squares optimum of the points that `used` names.

    A camera that the file holds exactly stays as it is: its fit ended there but for a weak prior.
    """
    camera = conversion.camera
    used = conversion.used or used_points(camera, source.views)
    if conversion.error == 0:
        return replace(conversion, used=used)
    views = [v.subset(m) for v, m in zip(source.views, used, strict=True)]
    views = [view for view in views if len(view) >= MIN_USED_POINTS]
    model, obs = models.get(camera.model), Observations.of(views)
    try:
        with np.errstate(all="ignore"):  # a step too far is tested before it is taken
            problem = Problem(model, obs, camera.img_size)
            poses, _ = resection.resect(model, camera.intrinsics, obs)
            state = problem.solve(problem.at(camera.intrinsics, poses), obs.mask.astype(np.float64), FREE)
        if not np.isfinite(state.k).all():
            return replace(conversion, used=used)
        better = Camera.from_intrinsics(camera.model, state.k, camera.img_size)
        return replace(compare(source.camera, better), used=used)
    except (CalibrationError, np.linalg.LinAlgError):
        return replace(conversion, used=used)


def used_points(camera: Camera, views: Sequence[View]) -> tuple[Mask, ...]:
    """Return for each view which points (n,) a robust fit at a camera keeps; all where it fails."""
    everything = tuple(np.ones(len(view), dtype=bool) for view in views)
    try:
        poses = resection.reprojection_score(camera, views).poses
        if not np.isfinite(poses).all():
            return everything
        return refine(views, camera, poses).used
    except CalibrationError:
        return everything


def resect_used(camera: Camera, views: Sequence[View], used: Sequence[Mask]) -> Array:
    """Return the poses (v, 6) of views by the points of each that count."""
    kept = [
        view.subset(mask) if mask.sum() >= MIN_USED_POINTS else view
        for view, mask in zip(views, used, strict=True)
    ]
    return np.array(resection.reprojection_score(camera, kept).poses)
