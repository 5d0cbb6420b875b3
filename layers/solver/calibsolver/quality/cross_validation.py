"""Error on views that took no part in the fit."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, frozen
from ..camera import Camera
from ..errors import CalibrationError, undetermined
from ..fitting.constraint import Fix
from ..fitting.fit import fit
from ..fitting.resection import reprojection_score
from ..fitting.validation import degenerate_views, pack
from ..view import View

FOLDS = 5
"""Parts of the views that are left out in turn."""


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Result of a cross-validation.

    Attributes
    ----------
    rms
        px, root of the mean square distance over all points of the views left out.
    view_errors
        (v,) px, rms of each view when it was left out; NaN of a degenerate view, which has no pose.
    """

    rms: float
    view_errors: Array


@undetermined()
def held_out(
    views: Sequence[View],
    img_size: tuple[int, int],
    model: str = "rectilinear",
    *,
    board_shape: bool = True,
    start: Camera | None = None,
    fix: Fix = (),
) -> HeldOut:
    """Cross-validate: intrinsics from the training views, the poses of the held-out views fitted.

    The parameters are those of `fit`. View i is left out in part i mod FOLDS.

    Raises
    ------
    CalibrationError
        ``too_few_views`` if no training view would be left, or what the fit of a part raises.
    """
    part = np.arange(len(views)) % FOLDS
    if len(views):
        part = np.where(degenerate_views(pack(views, img_size)), -1, part)
    parts = [np.flatnonzero(part == p).tolist() for p in np.unique(part[part >= 0])]
    if not parts or any(len(left) == len(views) for left in parts):
        raise CalibrationError("too_few_views", "without the views left out there are none to fit")
    errors, counts = np.full(len(views), np.nan), np.array([len(view) for view in views])
    for left in parts:
        training = [view for i, view in enumerate(views) if i not in left]
        found = fit(training, img_size, model, start=start, fix=fix, board_shape=board_shape)
        shaped = found.shaped([views[i] for i in left])
        errors[left] = reprojection_score(found.camera, shaped).view_errors
    seen = part >= 0
    return HeldOut(float(np.sqrt(np.average(errors[seen] ** 2, weights=counts[seen]))), frozen(errors))
