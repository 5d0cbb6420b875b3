"""Search for the rivals of a calibration among the other models."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from .. import models
from ..errors import CalibrationError
from ..fitting.calibration import Calibration
from ..fitting.fit import fit
from ..fitting.rivals import Hull, Rival, Rivals
from ..view import View
from .model_selection import MAX_EQUAL_RATIO


def with_rivals(calibration: Calibration, views: Sequence[View]) -> Calibration:
    """Calibration with the cameras of other models that explain its `views` as well, in the board's shape.

    Its uncertainty outside the hull of the corners then includes how far the others differ.
    """
    shaped, size = calibration.shaped(views), calibration.camera.img_size
    rivals = []
    for name in models.NAMES:
        if name == calibration.camera.model:
            continue
        with suppress(CalibrationError):
            other = fit(shaped, size, name, board_shape=False)
            if other.noise <= MAX_EQUAL_RATIO * calibration.noise:
                rivals.append(Rival(other.camera, other.covariance))
    pairs = zip(views, calibration.used, strict=True)
    hull = Hull.of(np.concatenate([view.image_points[used] for view, used in pairs]))
    return replace(calibration, rivals=Rivals(tuple(rivals), hull))
