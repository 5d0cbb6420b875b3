"""Mode of a camera: which of several known cameras took some views."""

import math
from collections.abc import Sequence

from ..camera import Camera
from ..errors import CalibrationError, undetermined
from ..fitting.fit import fit
from ..fitting.resection import reprojection_score
from ..view import View

NOISE_FLOOR_WIDTHS = 1e-4
MAX_SPECIMEN_WIDTHS = 2e-3
"""Error of views / image width that another specimen of the product may have, besides their noise."""
MIN_CONTRAST = 2.0
"""Error under the second best camera / under the best, from which the best is the one."""


@undetermined()
def fitting_camera(cameras: Sequence[Camera], views: Sequence[View], model: str) -> int | None:
    """Index of the one camera that took the views; None if none did, or if several may have.

    A fit of `model` estimates the noise of the views; raises CalibrationError as `fit` does.
    """
    if len(cameras) < 2:
        return None
    size = cameras[0].img_size
    noise = math.sqrt(2) * fit(views, size, model).noise
    expected = max(noise, NOISE_FLOOR_WIDTHS * size[0])
    errors = [_error(camera, views) for camera in cameras]
    best, second = sorted(range(len(errors)), key=errors.__getitem__)[:2]
    if errors[best] > math.hypot(expected, MAX_SPECIMEN_WIDTHS * size[0]):
        return None
    return best if errors[second] > MIN_CONTRAST * max(errors[best], expected) else None


def _error(camera: Camera, views: Sequence[View]) -> float:
    try:
        return reprojection_score(camera, views).rms
    except CalibrationError:
        return math.inf
