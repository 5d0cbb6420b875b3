"""Outlier rejection: the inlier mask of points, and whole views that fit nowhere."""

import math
from collections.abc import Sequence

import numpy as np

from ..arrays import IntArray, Mask
from . import plausibility
from .homography import medians
from .levenberg_marquardt import NOISE_FLOOR, Options, Problem, State, robust_sigma
from .validation import MIN_POINTS

OUTLIER_SIGMAS = 4.0
"""One in 3000 good points lies beyond."""
GROSS_OUTLIER_SIGMAS = 6.0
"""Points beyond are cut first, so that the rest is tested against a fit without them."""
RIM_SHARE = 0.01
MAX_CHANCE_RIM_OUTLIERS = 0.4
"""Share of the points at the rim that chance may make outliers."""
MIN_RIM_EXCESS = 4.0
"""Share of outliers at the rim / among all points, from which they concentrate there."""
MIN_RIM_POINTS = 12
MIN_INLIER_SHARE = 0.5
"""Share of its points that a view keeps at least: with fewer it contradicts the others as a whole."""
MAX_COUNTED_SIGMAS = 6.0
"""Sigmas at which the distance of a point is cut off when fits are compared."""
MAX_GROSS_REJECTIONS = 4
"""A model that is too simple would lose point after point."""
ROBUST_OPTIMUM = Options(robust=True, tolerance=1e-6, one_step=True)
"""Tight: no mask may depend on where the solver happens to stop."""
LEAST_SQUARES = Options(tolerance=1e-7, one_step=True)


def reject_gross(problem: Problem, state: State, mask: Mask) -> tuple[State, Mask, bool]:
    """Fit without gross outliers, from a state near the optimum, and its inlier mask (v, n).

    The first mask is that of the robust optimum, each other that of the least-squares fit to the one before,
    until two are equal. The last part of the result is True if the state is the least-squares fit to exactly
    the inliers.
    """

    def inliers() -> Mask:
        return inlier_mask(state, mask, mask, problem.width, GROSS_OUTLIER_SIGMAS)

    # A view of wrong corners would turn a pose, and then the camera.
    near = mask & inliers().any(axis=1, keepdims=True)
    state = problem.solve(state, near, ROBUST_OPTIMUM)
    good, previous = inliers(), mask
    for rejections in range(MAX_GROSS_REJECTIONS):
        if not good.any() or np.array_equal(good, previous):
            return state, good, rejections > 0
        state = problem.solve(state, good, LEAST_SQUARES)
        previous, good = good, inliers()
    return state, good, np.array_equal(good, previous)


def inlier_mask(state: State, mask: Mask, among: Mask, width: int, sigmas: float = OUTLIER_SIGMAS) -> Mask:
    """Inlier mask (v, n): points within so many `sigmas`; of a view that loses most of them, none.

    The noise is that of the points `among` (v, n), without those that were left out before.
    """
    good = near_points(state, mask, among, sigmas, width)
    if good is not mask:
        count = good.sum(axis=1)
        good &= (count >= np.maximum(MIN_POINTS, MIN_INLIER_SHARE * mask.sum(axis=1)))[:, None]
    return good


def near_points(state: State, mask: Mask, among: Mask, sigmas: float, width: int) -> Mask:
    """Mask (v, n) of the points within so many `sigmas`; `mask` itself if all are."""
    # Next to a view with unusually low noise, a view with usual noise is not an outlier.
    sigma = max(robust_sigma(state, among), NOISE_FLOOR * width)
    if not np.where(mask, state.square, 0.0).max() > (sigmas * sigma) ** 2:
        return mask
    # Real residuals have longer tails than the median promises; what is kept says how long.
    for _ in range(3):
        near = state.square[(state.square <= (sigmas * sigma) ** 2) & mask]
        if near.size:
            sigma = max(sigma, math.sqrt(float(near.sum()) / near.size / 2))
    return (state.square <= (sigmas * sigma) ** 2) & mask


def trimmed_rms(state: State, mask: Mask) -> float:
    """Root mean square, px, of the best three quarters of the residuals of points (v, n)."""
    square = np.sort(state.square[mask])[: max(3 * int(mask.sum()) // 4, 1)]
    return float(np.sqrt(np.mean(square) + 1e-12))


def rank_states(states: Sequence[State], problem: Problem, mask: Mask) -> list[State]:
    """Rank states: the likeliest first, with the prior; those that fold the views last.

    The distance of a point is bounded: else a state might win by what it does not explain.
    """
    if len(states) == 1:
        return list(states)
    sigma2 = min(trimmed_rms(state, mask) for state in states) ** 2 / 2

    def score(state: State) -> tuple[bool, float]:
        explained = np.minimum(state.square[mask] / sigma2, MAX_COUNTED_SIGMAS**2)
        folds = plausibility.folds(problem, state, mask)
        return folds, float(explained.sum() + state.prior_residuals @ state.prior_residuals)

    return sorted(states, key=score)


def views_beyond_threshold(state: State, mask: Mask) -> IntArray:
    """Views (by number) of which half of the points or more lie beyond OUTLIER_SIGMAS."""
    sigma = robust_sigma(state, mask)
    return np.flatnonzero((medians(state.square, mask) > (OUTLIER_SIGMAS * sigma) ** 2) & mask.any(axis=1))


def concentrate_at_rim(problem: Problem, good: Mask, among: Mask) -> bool:
    """True if the outliers `among` some points (v, n) concentrate at the rim of the image.

    There it may be the model that fails, unseen without these points.
    """
    if np.array_equal(good, among):
        return False
    offsets = problem.obs.pixels - (np.asarray(problem.img_size) / 2)[None, :, None]
    radius = np.hypot(offsets[:, 0], offsets[:, 1])[among]
    share = max(RIM_SHARE, min(MIN_RIM_POINTS / radius.size, 1.0))
    inner = math.ceil((radius.size - 1) * (1 - share))
    rim = radius >= np.partition(radius, inner)[inner]
    cut = ~good[among]
    share_of_rim = np.count_nonzero(cut & rim) / np.count_nonzero(rim)
    share_of_all = np.count_nonzero(cut) / cut.size
    return bool(share_of_rim > max(MAX_CHANCE_RIM_OUTLIERS, MIN_RIM_EXCESS * share_of_all))
