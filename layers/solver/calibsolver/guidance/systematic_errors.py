"""Fisher information of candidate views, limited by systematic errors: bend of the board, motion of the hand.

A view has information N about the intrinsics, and a systematic error of its own that would move them by a
covariance T. Together they give (N^-1 + T)^-1, however low the noise of its corners. T differs from view to
view: a bend shows most in a tilted close-up, motion wherever the board spans many rows. So the effects
(`fitting.systematic_effects`) enter as variables of the view that are marginalised with its pose, each with
the standard deviation that is typical of hand-held boards.
"""

import numpy as np

from ..arrays import Array
from ..fitting import normal_equations, systematic_effects
from ..fitting.normal_equations import Poses
from ..models import Model

NEGLIGIBLE_INFLATION = 1.5
"""Inflation that few views show by chance."""
USUAL_EXCESS_INFLATION = 3.0
"""Excess over it in the hands of people: the median of four to six views of 13 sets of real cameras."""
MAX_SHARE = 3.0
"""Largest size that is believed / the usual one: beyond, a view is an outlier."""


def limited_information(
    model: Model,
    k: Array,
    poses: Poses,
    points: Array,
    weights: Array,
    noise: float,
    img_height: int,
    systematic: float = 1.0,
) -> tuple[Array, Array]:
    """Fisher information (v, p, p) of the intrinsics at unit noise, limited by systematic errors; and pixels.

    Parameters
    ----------
    k
        (p,) intrinsics.
    points
        (v, 3, n) or, for all views, (3, n); board frame.
    weights
        (v, n) of the points.
    noise
        Standard deviation of a corner's coordinate, px: without the systematic errors.

    systematic
        Size of the systematic errors / the usual one, as `systematic_share` returns; 0: none.

    Pixels are (v, 2, n).
    """
    q, rows = normal_equations.linearize(model, k, poses, points, 0)
    count = 0
    if systematic > 0:
        row = systematic_effects.row_position(q[1], img_height)
        effects = systematic_effects.displacements(rows[model.size :], poses, points, row)
        nuisance = effects * (systematic / noise)
        count = len(nuisance)
        rows = np.concatenate([rows, nuisance])
    rows = np.where(weights > 0, rows * np.sqrt(weights), 0.0)
    s = normal_equations.schur_complement(normal_equations.gram_matrices(rows), nuisance=count)
    return s, q.transpose(1, 0, 2)


def systematic_share(inflation: float) -> float:
    """Size of the systematic errors / the usual one, by the inflation that a calibration's views show.

    The inflation is the variance of the intrinsics / that which white noise explains; its excess grows with
    the square of the systematic errors.
    """
    excess = inflation - NEGLIGIBLE_INFLATION
    return float(np.sqrt(np.clip(excess / USUAL_EXCESS_INFLATION, 0.0, MAX_SHARE**2)))
