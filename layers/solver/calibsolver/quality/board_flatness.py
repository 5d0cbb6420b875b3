"""Flatness of the board: its shape as the views tell it, used where cross-validation says that it helps."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import CalibrationError, undetermined
from ..fitting.board_shape import BoardShape, estimate_board_shape
from ..fitting.calibration import Calibration
from ..fitting.fit import fit
from ..fitting.resection import reprojection_score
from ..fitting.validation import degenerate_views, pack
from ..view import View
from .assessment import Reason

MIN_SHAPE_VIEWS = 10
"""Views from which the shape of a board can be told from the lens."""
FOLDS = 5
MIN_HELD_OUT_IMPROVEMENT = 0.005
"""Share by which the error on views left out must fall for the shape to be used."""
MAX_SQUARENESS_LOSS = 0.001
"""Growth of |fx / fy - 1|, of the focal lengths at the axis, up to which the shape is used. Pixels of cameras
are square: a stretch of the print that makes them less so is the lens or the shutter, not the print."""
MIN_REPORTED = 0.002
"""Sag or stretch / the board's longer side from which a user is told."""


@dataclass(frozen=True, eq=False)
class ShapedFit:
    """A fit that took the shape of the board into account where that helps.

    Attributes
    ----------
    calibration
        Of the board as drawn, or in its shape where `used`.
    shape
        As estimated; None with fewer than MIN_SHAPE_VIEWS views, or where it did not settle.
    used
        Whether cross-validation says that the shape helps.
    held_out, held_out_shaped
        px, rms on views left out: with the board as drawn, and in its shape; NaN without a shape.
    """

    calibration: Calibration
    shape: BoardShape | None
    used: bool
    held_out: float
    held_out_shaped: float

    @property
    def reported(self) -> bool:
        """Whether the board is so far from its drawing that a user should know."""
        return self.shape is not None and self.used and max(self.shape.sag, self.shape.stretch) > MIN_REPORTED


@undetermined()
def fit_with_board_shape(
    views: Sequence[View], img_size: tuple[int, int], model: str = "rectilinear"
) -> ShapedFit:
    """Fit the views with the board as drawn and in the shape that they tell; keep what predicts better.

    Raises CalibrationError as `fit` does.
    """
    return shaped_fit(fit(views, img_size, model), views)


@undetermined()
def shaped_fit(calibration: Calibration, views: Sequence[View]) -> ShapedFit:
    """Take the shape of the board into account in a calibration of `views`, if that predicts better."""
    img_size = calibration.camera.img_size
    usable = int(np.sum(~degenerate_views(pack(views, img_size)))) - len(calibration.cut_views)
    nothing = ShapedFit(calibration, None, False, np.nan, np.nan)
    if usable < MIN_SHAPE_VIEWS:
        return nothing
    try:
        shape, shaped = estimate_board_shape(views, calibration)
        flat_error, shaped_error = held_out_errors(views, calibration)
    except CalibrationError:
        return nothing
    loss = squareness_error(shaped) - squareness_error(calibration)
    used = shaped_error < (1 - MIN_HELD_OUT_IMPROVEMENT) * flat_error and loss < MAX_SQUARENESS_LOSS
    return ShapedFit(shaped if used else calibration, shape, used, flat_error, shaped_error)


def squareness_error(calibration: Calibration) -> float:
    """Deviation of the ratio of the focal lengths at the axis from 1."""
    fx, fy = calibration.camera.focal
    return abs(float(fx / fy) - 1)


def held_out_errors(views: Sequence[View], calibration: Calibration) -> tuple[float, float]:
    """Rms on views left out, px: with the board as drawn, and in the shape that the other views tell.

    Poses of the views left out are fitted. Points and views that the `calibration` of all views cut count for
    neither.
    """
    size, model = calibration.camera.img_size, calibration.camera.model
    counted = [i for i in range(len(views)) if calibration.used[i].sum() >= 6]
    kept = [
        View(views[i].object_points[calibration.used[i]], views[i].image_points[calibration.used[i]])
        for i in counted
    ]
    squares, points = np.zeros(2), 0
    for fold in range(FOLDS):
        training = [view for i, view in enumerate(kept) if i % FOLDS != fold]
        test = kept[fold::FOLDS]
        flat = fit(training, size, model)
        shape, shaped = estimate_board_shape(training, flat)
        errors = (
            reprojection_score(flat.camera, test).rms,
            reprojection_score(shaped.camera, [shape.apply(view) for view in test]).rms,
        )
        count = sum(len(view) for view in test)
        squares += count * np.array(errors) ** 2
        points += count
    flat_error, shaped_error = np.sqrt(squares / points)
    return float(flat_error), float(shaped_error)


def board_reasons(found: ShapedFit) -> tuple[Reason, ...]:
    """Word what a user should know of the board: nothing where it is as drawn."""
    if not found.reported or found.shape is None:
        return ()
    what = []
    if found.shape.sag > MIN_REPORTED:
        what.append(f"bent by {found.shape.sag:.1%} of its length")
    if found.shape.stretch > MIN_REPORTED:
        what.append(f"printed {found.shape.stretch:.1%} out of shape")
    text = f"the board is {' and '.join(what)}, which was taken into account: glue it to something rigid"
    return (Reason("board_not_flat", text),)
