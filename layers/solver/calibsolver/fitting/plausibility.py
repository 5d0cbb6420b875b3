"""Plausibility checks that refuse a camera that cannot exist."""

import numpy as np

from ..arrays import Mask
from ..errors import CalibrationError
from ..phrasing import off, times
from .levenberg_marquardt import Problem, State

WORST, WORST_KEPT = 0.01, 0.005
"""A fit whose rms exceeds this share of the image width explains nothing; without outliers
it has no excuse."""
SHORTEST, LONGEST = 0.05, 50.0
"""Focal lengths of cameras / image width."""
OBLONG = 2.0
"""Width of pixels / height, at most; and the other way round."""
FOLDED, LOST = 0.05, 0.003
"""Share of the points that may lie beyond the model's one-to-one domain and yet fit: its image ends a little
inside the views. And of those that were cut there: the model has no place for them."""


def folded(problem: Problem, state: State, mask: Mask) -> float:
    """Share of the points (v, n) that lie where the model is not one-to-one, or behind the camera."""
    p = state.poses.camera_points(problem.obs.points).transpose(1, 0, 2)
    inside = problem.model.valid(state.k[4:], p)
    return 1 - float(np.mean(inside[mask]))


def demand(problem: Problem, state: State, good: Mask, robust: bool) -> None:
    """Raise CalibrationError ``not_believable`` unless camera and `good` points (v, n) are plausible."""
    k, (w, h), mask = state.k, problem.img_size, problem.obs.mask
    if not (np.isfinite(k).all() and state.is_finite):
        raise CalibrationError("not_believable", "the fit ran away")
    focal = k[:2] * problem.model.magnification(k[4:])[0]
    if not (SHORTEST * w < focal[0] < LONGEST * w and 1 / OBLONG < k[0] / k[1] < OBLONG):
        raise CalibrationError("not_believable", strange(float(focal[0] / w), float(k[0] / k[1])))
    if not (-0.25 * w < k[2] < 1.25 * w and -0.25 * h < k[3] < 1.25 * h):
        raise CalibrationError("not_believable", "the principal point lies far outside the image")
    if good.sum() < 0.5 * mask.sum():
        raise CalibrationError("not_believable", "more than half of the points are outliers")
    level = float(np.sqrt(np.mean(state.square[good])))
    if level > (WORST_KEPT if robust else WORST) * w:
        raise CalibrationError("not_believable", f"what is {off(level, w)} explains nothing")
    taken = np.asarray(good.any(axis=1, keepdims=True))
    lost: Mask = mask & ~good & taken
    lost_share = folded(problem, state, lost) * lost.sum() / mask.sum() if lost.any() else 0.0
    if folded(problem, state, good) > FOLDED or lost_share > LOST:
        raise CalibrationError("not_believable", "the distortion folds inside the views")


def strange(focal: float, ratio: float) -> str:
    """Name the implausible part: the focal length, in image widths, or the shape of the pixels, fx / fy."""
    if focal <= SHORTEST:
        return f"a focal length below {SHORTEST:.0%} of the image's width is no camera's"
    if not focal < LONGEST:
        return f"a focal length of over {LONGEST:.0f} image widths is no camera's"
    return f"pixels {times(max(ratio, 1 / ratio))} as long as wide are no camera's"
