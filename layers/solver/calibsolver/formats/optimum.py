"""Cameras at the least-squares optimum of the points that they were fitted to, where a tool expects them."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Mask
from ..camera import Camera
from ..errors import CalibrationError
from ..fitting import resection
from ..fitting.fit import refine
from ..view import View
from .base import Conversion, ExportSource, ModelConstraint
from .convert import all_points, compare, fit_constrained

MIN_USED_POINTS = 6
"""Points of a view with which it counts."""


def at_optimum(source: ExportSource, conversion: Conversion) -> Conversion:
    """Return a conversion whose camera is the least-squares optimum of the points that `used` names.

    A camera that the file holds exactly stays as it is: its fit ended there but for a weak prior.
    """
    camera = conversion.camera
    used = conversion.used or _used_points(camera, source.views)
    if conversion.error == 0:
        return replace(conversion, used=used)
    subsets = [v.subset(m) for v, m in zip(source.views, used, strict=True)]
    views = tuple(view for view in subsets if len(view) >= MIN_USED_POINTS)
    try:
        better = fit_constrained(camera, ModelConstraint(camera.model), views, all_points(views))
        return replace(compare(source.camera, better), used=used)
    except (CalibrationError, np.linalg.LinAlgError):
        return replace(conversion, used=used)


def _used_points(camera: Camera, views: Sequence[View]) -> tuple[Mask, ...]:
    """Return for each view which points (n,) a robust fit at a camera keeps; all if it fails."""
    try:
        poses = resection.reprojection_score(camera, views).poses
        if np.isfinite(poses).all():
            return refine(views, camera, poses).used
    except CalibrationError:
        pass
    return all_points(views)
