"""Cluster-robust covariance of the intrinsics: error bars that hold where residuals are not white noise.

On real cameras the corners of one view err together: the board bends, the shutter rolls, the hand moves, the
model is a little too simple. What a view pulls the intrinsics by is then more than its corners' noise
explains, and independent from view to view: the views are the clusters of a "sandwich" covariance (Huber
1967; White 1980; Liang & Zeger 1986). Of few clusters it is vague and has no full rank, so it gives the
*shape* of the covariance alone, shrunk towards that of white noise (Ledoit & Wolf 2004); its *size* is one
factor, the inflation, with a prior of its own (Gelman et al., "Bayesian Data Analysis", 2.6).

With M the information of all views and of the prior at unit noise, T a whitening (T'MT = 1), of cluster c the
whitened gradient h = T'g and information B = T'ST: white noise of variance sigma^2 gives h the covariance
sigma^2 Q, Q = B - B^2, since each cluster takes part in the fit (Bell & McCaffrey 2002). Then

    inflation f = (n tr(W sum hh') / (sigma^2 tr(W sum Q)) + n0 f0) / (n + n0),  at least 1,
    covariance = sigma^2 T [1 - sum B + f (sum B - w sum Q) + w (f / f1) sum hh' / sigma^2] T'

with f1 the first quotient, without the prior of f; W the metric of the projection error, whitened; n the
degrees of freedom of the quotient (Satterthwaite 1946); w = clusters / (clusters + p). Under white noise it
is somewhat larger than sigma^2 M^-1: by the prior of f, and as f is at least 1. What the intrinsics' prior
contributes, 1 - sum B, is not inflated. It is positive definite always: sum B >= sum Q, and w < 1.

Views in nearly the same pose share what is wrong in it: frames of a video, or of a burst, are one cluster.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, IntArray, Mask, whitening
from . import normal_equations
from .normal_equations import Poses
from .observations import Observations

PRIOR_INFLATION, PRIOR_INFLATION_FREEDOM = 1.5, 6.0
"""Prior of the inflation, and its weight in degrees of freedom: between white noise (1) and real cameras."""
SAME_POSE_WIDTHS = 0.02
"""Distance between two views of the board, rms over its corners / image width, up to which they are one
cluster."""
MIN_EXPECTED = 1e-9
"""Share of the metric below which the views say nothing of their own error."""
MAX_BLOCK_ROWS = 1024
"""Rows of the matrix of distances that are computed at once."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """Information and gradient of each cluster of views, at unit noise.

    Attributes
    ----------
    information
        (c, p, p) Fisher information, poses marginalised.
    gradient
        (c, p) half gradient of the squared residuals there, poses marginalised, px^2 per unit.
    metric
        (p, p) W: trace(covariance W) is the mean square projection error at the corners seen, with the
        rotation of the camera frame that fits best removed, px^2.
    """

    information: Array
    gradient: Array
    metric: Array

    @classmethod
    def of(cls, rows: Array, poses: Poses, labels: IntArray, metric: Array | None = None) -> "Evidence":
        """Gather the evidence of rows (p + 7, 2, v, n), poses and the cluster (v,) of each view.

        The last row holds the residuals, px; points that do not count have rows of 0. A `metric` (p, p) takes
        the place of the one at the corners seen, which is that of one camera.
        """
        left = normal_equations.residual_jacobian(rows[:-1])
        transposed = left.transpose(0, 2, 1)
        r = rows[-1].transpose(1, 0, 2).reshape(*left.shape[:2], 1)
        information, gradient = transposed @ left, (transposed @ r)[:, :, 0]
        count = int(labels.max()) + 1
        if count < len(labels):
            information, gradient = _sum_by(information, labels, count), _sum_by(gradient, labels, count)
        if metric is None:
            metric = _observed_error_metric(rows, poses)
        return cls(information, gradient, metric)


def _sum_by(values: Array, labels: IntArray, count: int) -> Array:
    out = np.zeros((count, *values.shape[1:]))
    np.add.at(out, labels, values)
    return out


def _observed_error_metric(rows: Array, poses: Poses) -> Array:
    """Metric (p, p) of the projection error at the corners of rows (p + 7, 2, v, n); see `Evidence`."""
    size = len(rows) - normal_equations.POSE_SIZE - 1
    x, y, z = poses.t.T[:, :, None]
    bx, by, bz = rows[size + 3 : size + 6]
    # The pose turns about the board's origin; about the camera's centre adds t x b.
    turn = rows[size : size + 3].copy()
    turn[0] += y * bz - z * by
    turn[1] += z * bx - x * bz
    turn[2] += x * by - y * bx
    flat = np.concatenate([rows[:size], turn]).reshape(size + 3, -1)
    gram = flat @ flat.T
    by_turn = gram[size:, :size]
    removed = by_turn.T @ normal_equations.solve_or_nan(gram[size:, size:], by_turn)
    metric: Array = (gram[:size, :size] - removed) / (flat.shape[1] / 2)
    return metric if np.isfinite(metric).all() else gram[:size, :size]


@dataclass(frozen=True, eq=False)
class Result:
    """Covariance of the intrinsics and what it was made of.

    Attributes
    ----------
    covariance
        (p, p) cluster-robust covariance.
    information
        (p, p) Fisher information, the inverse of the covariance that white noise of the corners would give.
    inflation
        Variance of projections / that which white noise would give, >= 1.
    """

    covariance: Array
    information: Array
    inflation: float


def estimate(evidence: Evidence, sigma: float, prior_information: Array | None = None) -> Result:
    """Estimate the covariance of the intrinsics; see the module's docstring.

    Parameters
    ----------
    sigma
        px, standard deviation of one coordinate of a corner.
    prior_information
        (p, p) of the intrinsics' prior, in units of 1 / sigma^2; None where it took no part.
    """
    information = evidence.information.sum(axis=0)
    if prior_information is not None:
        information = information + prior_information
    basis = whitening(information)
    h = evidence.gradient @ basis
    b = basis.T @ evidence.information @ basis
    clusters, size = h.shape
    q = b - b @ b
    expected, scatter = q.sum(axis=0), h.T @ h / sigma**2
    inflation, ratio = _inflation(basis.T @ evidence.metric @ basis, b, q, scatter)
    shape = np.eye(size) + (inflation - 1) * b.sum(axis=0)
    if ratio > 0:
        weight = clusters / (clusters + size)
        shape = shape + weight * inflation * (scatter / ratio - expected)
    covariance: Array = sigma**2 * basis @ shape @ basis.T
    return Result((covariance + covariance.T) / 2, information / sigma**2, inflation)


def _inflation(w: Array, b: Array, q: Array, scatter: Array) -> tuple[float, float]:
    """Inflation, and the quotient that it follows from (0 where there is none); matrices are whitened.

    Metric (p, p), information and its share that shows in the gradients (c, p, p), and the gradients' scatter
    (p, p).
    """
    wq = w @ q
    expected = float(np.trace(wq.sum(axis=0)))
    if not expected > MIN_EXPECTED * float(np.trace(w)):
        return PRIOR_INFLATION, 0.0
    # Two clusters c, d have the covariance sigma^2 (B_c [c = d] - B_c B_d).
    bwb = b @ w @ b
    both = bwb.sum(axis=0)
    spread = _dot(wq, wq.transpose(0, 2, 1)) + _dot(both, both) - _dot(bwb, bwb)
    freedom = expected**2 / max(spread, 1e-300)
    ratio = _dot(w, scatter) / expected
    mean = (freedom * ratio + PRIOR_INFLATION_FREEDOM * PRIOR_INFLATION) / (freedom + PRIOR_INFLATION_FREEDOM)
    return max(mean, 1.0), ratio


def _dot(one: Array, other: Array) -> float:
    return float(np.vdot(one, other))


def same_pose_labels(poses: Poses, obs: Observations, used: Mask, focal_widths: float) -> IntArray:
    """Assign views in nearly the same pose to clusters (v,), numbered from 0.

    In the order of the views, each joins the first one before it that is near and began a cluster: a slow
    movement makes several.

    Parameters
    ----------
    used
        (v, n) points that count.
    focal_widths
        px per radian / image width.
    """
    p = obs.points.transpose(1, 0, 2)[:2, used]
    low, high = p.min(axis=1), p.max(axis=1)
    corners = np.array([[low[0], high[0], high[0], low[0]], [low[1], low[1], high[1], high[1]], [0.0] * 4])
    seen = poses.camera_points(corners[None])
    seen *= (focal_widths / 2 / np.linalg.norm(seen.mean(axis=2), axis=1))[:, None, None]
    place = seen.reshape(len(seen), -1)
    near = _near(place)
    if near.sum() == len(near):
        return np.arange(len(near))
    labels = np.full(len(near), -1)
    for i in range(len(near)):
        if labels[i] < 0:
            labels[near[i] & (labels < 0)] = i
    return np.unique(labels, return_inverse=True)[1]


def _near(place: Array) -> Mask:
    """Tell (v, v) which rows (v, m) are nearer to one another than SAME_POSE_WIDTHS."""
    square = np.sum(place**2, axis=1)
    out = np.empty((len(place), len(place)), dtype=bool)
    for first in range(0, len(place), MAX_BLOCK_ROWS):
        block = slice(first, first + MAX_BLOCK_ROWS)
        distance = square[block, None] + square - 2 * place[block] @ place.T
        out[block] = distance < SAME_POSE_WIDTHS**2
    np.fill_diagonal(out, True)
    return out
