"""Outlier rejection: inlier masks of points, and excluded views."""

from collections.abc import Sequence

import numpy as np

from ..arrays import Array, IntArray, Mask
from . import levenberg_marquardt, plausibility
from .levenberg_marquardt import Problem, State
from .observations import Observations
from .robust_homography import medians
from .validation import MIN_POINTS

CUT = 4.0
"""Sigmas beyond which a point is an outlier: one in 3000 good ones."""
WILD = 6.0
"""Sigmas beyond which it certainly is one. They go first: then the rest is judged by a fit that has not seen
them, the same as if they had never been there."""
RIM, MOST, TIMES = 0.01, 0.4, 4.0
"""Outermost share of the points, the share of those that bad luck alone does not cut, and how many times that
of all points it is then."""
LEFT = 0.5
"""Share of its points that a view keeps at least: with fewer it contradicts the others as a whole."""
MOST_COUNTED = 6.0
"""Sigmas beyond which it does not matter any more how far away a point is, when fits are compared."""


def kept(state: State, mask: Mask, among: Mask, cut: float, img_size: tuple[int, int]) -> Mask:
    """Points (v, n) within `cut` sigmas; of a view that loses most of them, none.

    The noise is that of the points `among` (v, n): what has been left out already does not blur what is left.
    """
    # Beside a view that happens to have less noise, one with as much as others have is no outlier.
    sigma = max(levenberg_marquardt.robust_sigma(state, among), levenberg_marquardt.NOISE_FLOOR * img_size[0])
    if not np.where(mask, state.square, 0.0).max() > (cut * sigma) ** 2:
        return mask
    # Real residuals have longer tails than the median promises; what is kept says how long.
    for _ in range(3):
        near = state.square[(state.square <= (cut * sigma) ** 2) & mask]
        sigma = max(sigma, float(np.sqrt(np.mean(near) / 2)))
    good: Mask = (state.square <= (cut * sigma) ** 2) & mask
    count = good.sum(axis=1)
    good &= (count >= np.maximum(MIN_POINTS, LEFT * mask.sum(axis=1)))[:, None]
    return good


def level(state: State, mask: Mask) -> float:
    """Root mean square, px, of the best three quarters of the residuals of points (v, n)."""
    square = np.sort(state.square[mask])[: max(3 * int(mask.sum()) // 4, 1)]
    return float(np.sqrt(np.mean(square) + 1e-12))


def ranked(states: Sequence[State], problem: Problem, mask: Mask) -> list[State]:
    """Sort states: the likeliest first, with the prior; those that fold the views last.

    A point counts up to some sigmas, the same for all: else a state might win by what it does not explain.
    """
    if len(states) == 1:
        return list(states)
    sigma2 = min(level(state, mask) for state in states) ** 2 / 2

    def score(state: State) -> tuple[bool, float]:
        explained = np.minimum(state.square[mask] / sigma2, MOST_COUNTED**2)
        folds = plausibility.folded(problem, state, mask) > plausibility.FOLDED
        return folds, float(explained.sum() + state.prior_residuals @ state.prior_residuals)

    return sorted(states, key=score)


def unfit(state: State, mask: Mask) -> IntArray:
    """Find views (by number) of which half of the points or more lie beyond CUT sigmas."""
    sigma = levenberg_marquardt.robust_sigma(state, mask)
    return np.flatnonzero((medians(state.square, mask) > (CUT * sigma) ** 2) & mask.any(axis=1))


def weights(good: Mask) -> Array:
    """Weights (v, n): 1 for the good, 0 for others. The pose of a view without any stays where it is."""
    return good.astype(np.float64)


def systematic(good: Mask, among: Mask, obs: Observations, img_size: tuple[int, int]) -> bool:
    """Whether the points cut `among` some (v, n) are those at the rim of the image.

    Corners that were found badly lie anywhere. Where the rim is cut it may be the model that fails there,
    and without these points it would fail unseen.
    """
    if np.array_equal(good, among):
        return False
    seen = obs.pixels - (np.asarray(img_size) / 2)[None, :, None]
    radius = np.hypot(seen[:, 0], seen[:, 1])[among]
    share = max(RIM, min(12 / radius.size, 1.0))  # of a few points one or two say nothing
    rim = radius >= np.quantile(radius, 1 - share)
    cut = ~good[among]
    return bool(np.mean(cut[rim]) > max(MOST, TIMES * np.mean(cut)))
