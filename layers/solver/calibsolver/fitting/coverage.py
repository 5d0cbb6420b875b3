"""Error inside the part of the image that the board has shown: the convex hull of its corners.

Outside the hull a calibration extrapolates. The rotation that fits best inside the hull is removed: a pose
estimated from points there absorbs it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..arrays import Array, Mask
from ..camera import pixel_grid
from ..view import View
from .calibration import Calibration
from .uncertainty import Hull, square_errors

COVERAGE_GRID = (40, 30)
MIN_CELLS = 4
"""Cells in the hull below which only the error over the whole image is stated."""


@dataclass(frozen=True)
class Coverage:
    """Share of the image that the board has shown, and predicted error of a projection inside it, px rms."""

    share: float
    rms: float

    @classmethod
    def of(cls, calibration: Calibration, views: Sequence[View]) -> "Coverage":
        """Measure the hull of the corners used in the `views` of a calibration, and its error there."""
        camera = calibration.camera
        pairs = zip(views, calibration.used, strict=True)
        inside = hull(np.concatenate([view.image_points[used] for view, used in pairs]), camera.img_size)
        square = square_errors(camera, calibration.covariance, COVERAGE_GRID, inside)
        square = square[np.isfinite(square)]
        if len(square) < MIN_CELLS:
            return cls(float(inside.mean()), calibration.uncertainty().rms)
        return cls(float(inside.mean()), float(np.sqrt(square.mean())))


def hull(points: Array, img_size: tuple[int, int]) -> Mask:
    """True (n,) for cells of COVERAGE_GRID with their centre in the convex hull of `points` (m, 2), px."""
    return Hull.of(points).contains(pixel_grid(img_size, COVERAGE_GRID).reshape(2, -1).T)


def record_covered(calibration: Calibration, coverage: Coverage) -> dict[str, Any]:
    """Record of a calibration (`Calibration.record`) with the error where the board has been."""
    plain = calibration.record()
    return {**plain, "uncertainty": {**plain["uncertainty"], **uncertainty_members(coverage)}}


def uncertainty_members(coverage: Coverage) -> dict[str, float]:
    """Members that a coverage adds to a recorded uncertainty."""
    return {"inside": coverage.rms, "covered": coverage.share}
