"""Degenerate views in the result of a fit: they took no part in it, and are listed with the others."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array, Mask, frozen
from ..view import View
from .calibration import Calibration


def with_degenerate_views(calibration: Calibration, views: Sequence[View], degenerate: Mask) -> Calibration:
    """Add the views that were set aside to the calibration of the others, with reason ``degenerate``.

    Points on a line have no pose: many explain them, and no linear solution finds one. So pose and errors of
    these views are NaN, and do not count in `avg_reprojection_error`.

    Parameters
    ----------
    calibration
        Fitted to the views that are not `degenerate`, in their order.
    views
        All views.
    degenerate
        (v,) views whose points lie on a line or in one place.
    """
    usable = np.flatnonzero(~degenerate)
    poses, errors = np.full((len(views), 6), np.nan), np.full(len(views), np.nan)
    poses[usable], errors[usable] = calibration.poses, calibration.view_errors
    residuals: list[Array] = [np.full((len(view), 2), np.nan) for view in views]
    used: list[Mask] = [np.zeros(len(view), dtype=bool) for view in views]
    for i, vectors, inliers in zip(usable, calibration.residuals, calibration.used, strict=True):
        residuals[i], used[i] = vectors, inliers
    reasons = {int(usable[i]): reason for i, reason in calibration.cut_views.items()}
    return replace(
        calibration,
        poses=frozen(poses),
        view_errors=frozen(errors),
        residuals=tuple(frozen(e) for e in residuals),
        used=tuple(used),
        cut_views=reasons | {int(i): "degenerate" for i in np.flatnonzero(degenerate)},
    )
