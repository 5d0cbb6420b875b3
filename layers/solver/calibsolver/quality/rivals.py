"""Search for the rivals of a calibration among the other models."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..fitting.calibration import Calibration
from ..fitting.uncertainty import Hull, Rival, Rivals
from ..view import View
from .model_selection import MAX_EQUAL_RATIO, fit_other_models


def with_rivals(calibration: Calibration, views: Sequence[View]) -> Calibration:
    """Calibration with the cameras of other models that explain its `views` as well, in the board's shape.

    Its uncertainty outside the hull of the corners then includes how far the others differ.
    """
    others = fit_other_models(calibration, calibration.shaped(views), board_shape=False)
    rivals = [
        Rival(other.camera, other.covariance)
        for other in others.values()
        if other.noise <= MAX_EQUAL_RATIO * calibration.noise
    ]
    pairs = zip(views, calibration.used, strict=True)
    hull = Hull.of(np.concatenate([view.image_points[used] for view, used in pairs]))
    return replace(calibration, rivals=Rivals(tuple(rivals), hull))
