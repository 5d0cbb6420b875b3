"""Comparison of known cameras with fresh views: whether one still fits, and which of several took them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..camera import Camera
from ..errors import CalibrationError, undetermined
from ..fitting.fit import fit
from ..fitting.resection import MIN_POSE_POINTS, reprojection_score
from ..view import View
from .agreement import difference

MAX_RMS_RATIO = 1.5
"""Error under the calibration / under a camera fitted to the views, up to which it fits."""
MAX_EXCESS_WIDTHS = 0.15 / 1280
"""Excess of the one over the other / image width up to which it fits as well."""
NOISE_FLOOR_WIDTHS = 1e-4
MAX_SPECIMEN_WIDTHS = 2e-3
"""Error of views / image width that another specimen of the product may have, besides their noise."""
MIN_CONTRAST = 2.0
"""Error under the second best camera / under the best, from which the best is the one."""


@dataclass(frozen=True)
class Comparison:
    """A calibration and the fit of fresh views.

    Attributes
    ----------
    fits
        True if the calibration explains the views about as well as their own fit.
    error, expected
        px rms of the views under it, and under a camera fitted to them; infinite if it explains none.
    drift
        px rms over the picture between the projections of the two cameras, see `difference`.
    drift_uncertainty
        px rms, standard deviation of the projections of the fit.
    views
        Number of views that count.
    """

    fits: bool
    error: float
    expected: float
    drift: float
    drift_uncertainty: float
    views: int


@undetermined()
def compare(camera: Camera, views: Sequence[View]) -> Comparison:
    """Compare a camera with a fit of `views` in its model; raises CalibrationError as `fit` does.

    Both errors are of the board in the shape that the fit finds.
    """
    own = fit(views, camera.img_size, camera.model)
    used = [
        view.subset(mask)
        for view, mask in zip(own.shaped(views), own.used, strict=True)
        if mask.sum() >= MIN_POSE_POINTS
    ]
    if not used:
        raise CalibrationError("too_few_points", "no view can show a board: too few of its corners fit")
    error = reprojection_score(camera, used).rms
    expected = reprojection_score(own.camera, used).rms
    limit = max(MAX_RMS_RATIO * expected, expected + MAX_EXCESS_WIDTHS * camera.img_size[0])
    with np.errstate(all="ignore"):  # a camera at hand may be nonsense
        drift = difference(camera, own.camera)
    return Comparison(
        bool(np.isfinite(error) and error <= limit),
        float(error),
        float(expected),
        drift,
        own.uncertainty().rms,
        len(used),
    )


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
