"""Admission of a single view to a capture, whatever came before it."""

from typing import Literal

import numpy as np

from ..errors import CalibrationError
from ..fitting.observations import Observations
from ..fitting.validation import MIN_POINTS, check, handedness
from ..view import View

Reason = Literal["too_few_points", "degenerate", "mirrored", "outlier", "duplicate", "no_information"]

MIN_EXTENT_WIDTHS = 0.005
"""Standard deviation of the points across their narrower direction / image width; below, they are a line."""


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
