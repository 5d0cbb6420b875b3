"""Systematic errors within a view: a board that bends, and a hand that moves while rows are read out.

A view that carries information N about the intrinsics and a systematic error of its own that would move them
by a covariance T tells (N^-1 + T)^-1, however low the noise of its corners. T differs from view to view: a
bend shows most in a tilted close-up, motion wherever the board spans many rows. So the causes enter as
variables of the view that are marginalised with its pose, each with the standard deviation that it has in the
hands of people: the sag of a board of paper (three quadratic terms of height), and the velocity of the board
while one frame is read out (six terms, in proportion to the row).
"""

import numpy as np

from ..arrays import Array
from ..fitting import normal_equations
from ..fitting.normal_equations import POSE_SIZE, Poses
from ..fitting.robust_covariance import PRIOR_INFLATION
from ..models import Model

SAG_STD_BOARDS = 0.003
"""Standard deviation of the height of each quadratic term at the board's rim / longer side."""
SHUTTER_ROTATION_STD_RAD = 0.001
"""Standard deviation of the rotation about each axis from the middle row of the image to an outermost one."""
SHUTTER_SHIFT_STD_BOARDS = 0.001
"""Standard deviation of the translation along each axis meanwhile / longer side of the board."""
USUAL_EXCESS_INFLATION = 3.0
"""Excess of the inflation over its prior, in the hands of people: the median of 33 sets of real cameras."""
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
        Standard deviation of a corner's coordinate, px: the systematic errors are meant beside it.

    systematic
        Size of the systematic errors / the usual one, as `systematic_share` tells; 0: none.

    Pixels are (v, 2, n).
    """
    q, rows = normal_equations.linearize(model, k, poses, points, 0)
    count = 0
    if systematic > 0:
        nuisance = nuisance_rows(model, poses, points, q, rows, img_height) * (systematic / noise)
        count = len(nuisance)
        rows = np.concatenate([rows, nuisance])
    rows = np.where(weights > 0, rows * np.sqrt(weights), 0.0)
    s = normal_equations.schur_complement(normal_equations.gram_matrices(rows), nuisance=count)
    return s, q.transpose(1, 0, 2)


def nuisance_rows(model: Model, poses: Poses, points: Array, q: Array, rows: Array, img_height: int) -> Array:
    """Displacements (9, 2, v, n), px, by a standard deviation of each cause: three of bend, six of motion.

    Of points (v, 3, n) or (3, n), seen at pixels q (2, v, n), with the Jacobian `rows` (p + 6, 2, v, n).
    """
    size, height = model.size, max(img_height / 2, 1.0)
    x, y = points[..., 0, :], points[..., 1, :]
    half = max(float(max(np.ptp(x), np.ptp(y))) / 2, 1e-9)
    across = (x - x.mean(axis=-1, keepdims=True)) / half
    down = (y - y.mean(axis=-1, keepdims=True)) / half
    by_height = np.einsum("kavn,vk->avn", rows[size + 3 : size + POSE_SIZE], poses.r[:, :, 2])
    sag = SAG_STD_BOARDS * 2 * half
    out = np.empty((3 + POSE_SIZE, *q.shape))
    for i, term in enumerate((across * across, across * down, down * down)):
        out[i] = by_height * (term * sag)
    row = (q[1] - (img_height - 1) / 2) / height
    np.multiply(rows[size : size + 3], row * SHUTTER_ROTATION_STD_RAD, out=out[3:6])
    np.multiply(rows[size + 3 : size + 6], row * (SHUTTER_SHIFT_STD_BOARDS * 2 * half), out=out[6:9])
    return out


def systematic_share(inflation: float) -> float:
    """Size of the systematic errors / the usual one, by the inflation that a calibration's views show.

    The inflation is the variance of the intrinsics / that which white noise explains; its excess grows with
    the square of the systematic errors. Few views say little: what its prior expects is no excess.
    """
    excess = inflation - PRIOR_INFLATION
    return float(np.sqrt(np.clip(excess / USUAL_EXCESS_INFLATION, 0.0, MAX_SHARE**2)))
