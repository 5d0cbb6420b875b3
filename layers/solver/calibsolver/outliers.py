"""Which measurements are believed."""

import numpy as np

from . import lm
from .arrays import Array, Mask
from .checks import MIN_POINTS
from .lm import State
from .observations import Observations

CUT = 4.0
"""Sigmas beyond which a point is an outlier: one in 3000 good ones."""
RIM, MOST = 0.01, 0.4
"""Outermost share of the points, and the share of those that bad luck alone does not cut."""
LEFT = 0.5
"""Share of its points that a view keeps at least: with fewer it contradicts the others as a whole."""
FAINT = 1e-9
"""Weight of what is left out: a pose is still found, and nothing else is moved."""


def kept(state: State, mask: Mask, img_size: tuple[int, int]) -> Mask:
    """Points (v, n) within CUT sigmas; of a view that loses most of them, none."""
    # Beside a view that happens to have less noise, one with as much as others have is no outlier.
    sigma = max(lm.noise(state, mask), lm.FINEST * img_size[0])
    # Real residuals have longer tails than the median promises; what is kept says how long.
    for _ in range(3):
        near = state.square[(state.square <= (CUT * sigma) ** 2) & mask]
        sigma = max(sigma, float(np.sqrt(np.mean(near) / 2)))
    good: Mask = (state.square <= (CUT * sigma) ** 2) & mask
    count = good.sum(axis=1)
    return good & (count >= np.maximum(MIN_POINTS, LEFT * mask.sum(axis=1)))[:, None]


def weights(good: Mask, mask: Mask) -> Array:
    """Weights (v, n): 1 for the good, 0 for others; faint ones in views that are left out as a whole."""
    out = good.astype(np.float64)
    lost = ~good.any(axis=1)
    out[lost] = FAINT * mask[lost]
    return out


def systematic(good: Mask, obs: Observations, img_size: tuple[int, int]) -> bool:
    """Whether the points cut are those at the rim of the image.

    Corners that were found badly lie anywhere. Where the rim is cut it may be the model that fails there,
    and without these points it would fail unseen.
    """
    seen = obs.pixels - (np.asarray(img_size) / 2)[None, :, None]
    radius = np.where(obs.mask, np.hypot(seen[:, 0], seen[:, 1]), 0.0)
    share = max(RIM, min(12 / obs.count, 1.0))  # of a few points one or two say nothing
    rim = radius >= np.quantile(radius[obs.mask], 1 - share)
    return bool(np.mean(~good[rim]) > MOST)
