"""Admission of a single view to a capture, whatever came before it."""

from typing import Literal

import numpy as np

from ..camera import Camera
from ..errors import CalibrationError
from ..fitting.observations import Observations
from ..fitting.resection import reprojection_score
from ..fitting.validation import MIN_POINTS, check, handedness
from ..view import View

Reason = Literal["too_few_points", "degenerate", "mirrored", "outlier", "duplicate", "no_information"]

MIN_EXTENT_WIDTHS = 0.005
"""Standard deviation of points across their narrower direction / image width; below, they are a line."""


def rejection_reason(view: View, img_size: tuple[int, int]) -> Reason | None:
    """Reason to refuse `view`; None if it may be used."""
    if len(view) < MIN_POINTS:
        return "too_few_points"
    try:
        check([view], img_size)
    except CalibrationError:
        return "degenerate"
    extent = np.linalg.svd(view.image_points - view.image_points.mean(axis=0), compute_uv=False)[1]
    if extent / np.sqrt(len(view)) < MIN_EXTENT_WIDTHS * img_size[0]:
        return "degenerate"  # so far away or so oblique that, within the noise, it is a line
    if handedness(Observations.of([view]))[0] < 0:
        return "mirrored"
    return None


FOCAL_WIDTHS = 0.15, 5.0
"""Least and largest focal length / image width of a seed."""
MAX_CENTER_OFFSET = 0.25
"""Distance of a seed's principal point from the centre / image size, along each axis."""
MAX_SEED_ERROR_WIDTHS = 0.003
"""Rms error / image width of the first view with only its pose fitted, up to which the seed poses it."""


def is_usable(seed: Camera, model: str, img_size: tuple[int, int]) -> bool:
    """True if a seed is of this model and image size, and a believable camera."""
    (w, h), k = img_size, seed.intrinsics
    if (seed.model, seed.img_size) != (model, img_size) or not np.isfinite(k).all():
        return False
    with np.errstate(all="ignore"):
        focal = seed.focal[0]
    centered = abs(k[2] - w / 2) < MAX_CENTER_OFFSET * w and abs(k[3] - h / 2) < MAX_CENTER_OFFSET * h
    return bool(FOCAL_WIDTHS[0] * w < focal < FOCAL_WIDTHS[1] * w and centered)


def is_posed(seed: Camera, view: View) -> bool:
    """True if a seed explains a view; otherwise it belongs to another camera."""
    with np.errstate(all="ignore"):  # hostile numbers are not a pose
        try:
            error = reprojection_score(seed, [view]).rms
        except CalibrationError:
            return False
    return bool(error <= MAX_SEED_ERROR_WIDTHS * seed.img_size[0])
