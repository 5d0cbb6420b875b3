"""Plausibility of a fitted camera."""

import numpy as np

from ..arrays import Mask
from ..errors import CalibrationError, format_factor, format_px_error
from .levenberg_marquardt import Problem, State

MAX_RMS_WIDTHS, MAX_INLIER_RMS_WIDTHS = 0.01, 0.005
"""Rms / image width that explains nothing; without outliers it has no excuse."""
MIN_FOCAL_WIDTHS, MAX_FOCAL_WIDTHS = 0.05, 50.0
MAX_PIXEL_ASPECT = 2.0
MAX_SHARE_OUTSIDE_DOMAIN = 0.05
"""Share of the points that may lie beyond the model's one-to-one domain: its image ends a little inside
the views."""
MAX_SHARE_CUT_OUTSIDE_DOMAIN = 0.003
"""Share of the points that may be cut beyond that domain: the model has no place for them."""


def inside_domain(problem: Problem, state: State) -> Mask:
    """True for the points (v, n) where the model is one-to-one, in front of the camera."""
    p = state.poses.camera_points(problem.obs.points).transpose(1, 0, 2)
    return problem.model.valid(state.k[4:], p)


def folds(problem: Problem, state: State, mask: Mask) -> bool:
    """True if too many of the points (v, n) lie outside the one-to-one domain, or behind the camera."""
    return 1 - float(np.mean(inside_domain(problem, state)[mask])) > MAX_SHARE_OUTSIDE_DOMAIN


def check_result(problem: Problem, state: State, good: Mask, robust: bool) -> None:
    """Raise CalibrationError ``not_believable`` unless camera and `good` points (v, n) are plausible."""
    if message := _implausibility(problem, state, good, robust):
        raise CalibrationError("not_believable", message)


def _implausibility(problem: Problem, state: State, good: Mask, robust: bool) -> str | None:
    k, (w, h), mask = state.k, problem.img_size, problem.obs.mask
    if not (np.isfinite(k).all() and state.is_finite):
        return "the fit diverged"
    focal, ratio = problem.focal_widths(k), float(k[0] / k[1])
    if focal <= MIN_FOCAL_WIDTHS:
        return f"no camera has a focal length below {MIN_FOCAL_WIDTHS:.0%} of the image's width"
    if not focal < MAX_FOCAL_WIDTHS:
        return f"no camera has a focal length above {MAX_FOCAL_WIDTHS:.0f} image widths"
    if not 1 / MAX_PIXEL_ASPECT < ratio < MAX_PIXEL_ASPECT:
        return f"pixels {format_factor(max(ratio, 1 / ratio))} as long as wide are no camera's"
    if not (-0.25 * w < k[2] < 1.25 * w and -0.25 * h < k[3] < 1.25 * h):
        return "the principal point lies far outside the image"
    if good.sum() < 0.5 * mask.sum():
        return "more than half of the points are outliers"
    level = float(np.sqrt(np.mean(state.square[good])))
    if level > (MAX_INLIER_RMS_WIDTHS if robust else MAX_RMS_WIDTHS) * w:
        return f"what is {format_px_error(level, w)} explains nothing"
    outside = ~inside_domain(problem, state)
    cut_outside = np.count_nonzero(mask & ~good & good.any(axis=1, keepdims=True) & outside)
    if (
        np.count_nonzero(good & outside) > MAX_SHARE_OUTSIDE_DOMAIN * good.sum()
        or cut_outside > MAX_SHARE_CUT_OUTSIDE_DOMAIN * mask.sum()
    ):
        return "the distortion folds inside the views"
    return None
