"""Robust covariance of the intrinsics: error bars that hold where residuals are not white noise.

On real cameras the corners of one view err together: the board bends, the hand moves during the readout.
These effects (`systematic_effects`) shift the intrinsics by far more than the noise of corners, and leave
their traces in the residuals. So they are random effects (Laird & Ware 1982), whose variances the residuals
show (method of moments, Rao 1970): motion different in each view, the same bend in all.

With M the information of all views and of the prior at unit noise, T a whitening (T'MT = 1), of cluster c the
whitened gradient h = T'g, information B = T'ST, and Z the effects there, their pose projected out:

    moments of the residuals r, which are (1 - AT T'A') (noise + Z effects), of Z'r in each cluster (motion)
    and over all (bend), give the variances of motion, m, and bend, s, in units of sigma^2. Only what exceeds
    the mean under white noise by a standard deviation counts. Points that the fit cut, but effects on their
    view explain, count here: motion moves them farthest.
    Where motion is most of the residuals, its likelihood may say that m is larger (`EffectLikelihood`).
    covariance = sigma^2 T [1 - sum B + f sum (B + m K_m K_m') + k (sum K_b) S (sum K_b)'] T'

with K = T'A'Z the pull of the effects on the intrinsics, S the second moment of the bend given the residuals
(few views may show less than s, then S is smaller), k the share `BEND_SHARE`, or more, up to 1, where the
bend is most of the residuals. The inflation f is for all other errors of a view. Views are the clusters of a
"sandwich" covariance (Huber 1967; White 1980; Liang & Zeger 1986), f the quotient of the gradients' scatter
and what noise and motion explain, corrected for the part that each cluster takes in the fit (Bell & McCaffrey
2002), with a prior (Gelman et al., "Bayesian Data Analysis", 2.6), and at least 1. The prior's 1 - sum B is
not inflated. The covariance is always positive definite, and under white noise hardly larger than sigma^2
M^-1.

Views in nearly the same pose, such as frames of a burst, share their errors and are one cluster.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .. import rotation
from ..arrays import Array, IntArray, Mask, dot, whitening
from .effect_variances import EffectLikelihood, EffectMoments, trust
from .normal_equations import (
    POSE_SIZE,
    Poses,
    Projection,
    products_of_rows,
    projected_gram_matrices,
    solve_or_nan,
)
from .observations import Observations

PRIOR_INFLATION_FREEDOM = 30.0
"""Degrees of freedom of the prior of f, which is 1."""
BEND_SHARE = 0.25
"""Share of the variance by the common bend that counts, unless it is most of what the residuals show. The
truth differs by all of it, a second calibration with the same board by nothing: with a quarter, half
in px, neither is more than twice as far as predicted."""
SAME_POSE_WIDTHS = 0.02
"""Distance between two views of the board, rms over its corners / image width, up to which they are a
cluster."""
MIN_EXPECTED = 1e-9
"""Share of the metric below which the views do not show their own error."""
MAX_BLOCK_NUMBERS = 2**15
"""Numbers of a Jacobian per block, which fit in the cache."""
MAX_BLOCK_ROWS = 1024


@dataclass(frozen=True, eq=False)
class Evidence:
    """Products of each cluster of views, poses projected out, at unit noise.

    Attributes
    ----------
    gram
        (c, p + e + 1, ...) Gram matrices of intrinsics, systematic effects and residuals, px^2.
    metric
        (p, p) W: trace(covariance W) is the mean square projection error at the corners seen, with the best
        rotation of the camera frame removed, px^2.
    of_effects
        As `gram`, also of points that the fit cut, but an effect explains; None: there are none.
    """

    gram: Array
    metric: Array
    of_effects: Array | None = None

    @classmethod
    def of(
        cls,
        rows: Array,
        effects: Array,
        poses: Poses,
        labels: IntArray,
        metric: Array | None = None,
        used: Mask | None = None,
    ) -> "Evidence":
        """Gather the evidence of the points `used` (v, n), or all, in clusters (v,) of views.

        `rows` (p + 7, 2, v, n), px, end with the residuals, `effects` (e, 2, v, n) are displacements. A
        `metric` (p, p) replaces that of one camera at the corners seen.
        """
        size, views = len(rows) - POSE_SIZE - 1, len(labels)
        columns = size + len(effects) + 1
        gram, turned = np.empty((views, columns, columns)), np.zeros((size + 3, size + 3))
        for block, parts, counted in _blocks(rows, effects, used):
            projection = Projection.of(parts, counted)
            gram[block] = products_of_rows(projection.left)
            if metric is None:
                turned += _turned_gram(projection, gram[block, :size, :size], poses.t[block])
        if metric is None:
            metric = _observed_error_metric(turned, rows[0].size / 2)
        return cls(_sum_by(gram, labels), metric)


def cluster_grams(rows: Array, effects: Array, labels: IntArray, used: Mask) -> Array:
    """Gram matrices (c, ...) as of `Evidence.of`: faster, but they lose digits."""
    gram = [projected_gram_matrices(parts, counted) for _, parts, counted in _blocks(rows, effects, used)]
    return _sum_by(np.concatenate(gram), labels)


def with_more_points(
    gram: Array, rows: Array, effects: Array, labels: IntArray, used: Mask, seen: Mask
) -> Array:
    """Gram matrices (c, ...) of the points `seen` (v, n) instead of those `used`."""
    changed = np.flatnonzero((seen != used).any(axis=1))
    part = rows[:, :, changed], effects[:, :, changed], np.arange(len(changed))
    change = cluster_grams(*part, seen[changed]) - cluster_grams(*part, used[changed])
    out = gram.copy()
    np.add.at(out, labels[changed], change)
    return out


def _blocks(
    rows: Array, effects: Array, used: Mask | None
) -> Iterator[tuple[slice, tuple[Array, ...], Mask | None]]:
    """Yield views in blocks: their rows in the order of `Evidence.gram`, the pose's last, and points used."""
    size, views = len(rows) - POSE_SIZE - 1, rows.shape[2]
    step = max(1, MAX_BLOCK_NUMBERS // ((len(rows) - POSE_SIZE + len(effects)) * rows[0, :, 0].size))
    for block in (slice(first, first + step) for first in range(0, views, step)):
        part, counted = rows[:, :, block], None if used is None or used[block].all() else used[block]
        yield block, (part[:size], effects[:, :, block], part[-1:], part[size:-1]), counted


def _sum_by(values: Array, labels: IntArray) -> Array:
    """Sums (c, ...) over the members of each cluster of values (v, ...)."""
    count = int(labels.max()) + 1
    if count == len(values):  # each is a cluster
        return values
    out = np.zeros((count, *values.shape[1:]))
    np.add.at(out, labels, values)
    return out


def _turned_gram(projection: Projection, left: Array, t: Array) -> Array:
    """Gram matrix (p + 3, p + 3) by intrinsics and a turn about the camera's centre, summed over the views.

    `left` (v, p, p): what the poses leave of the intrinsics' part; `t` (v, 3): places of the boards.
    """
    size = left.shape[1]
    by_pose = projection.by_pose[:, :, :size]
    # The pose turns about the board's origin; about the camera's centre adds t x b.
    cross = rotation.skew(t)
    by_turn = by_pose[:, :3] + cross @ by_pose[:, 3:]
    turn = projection.pose_gram[:, :3] + cross @ projection.pose_gram[:, 3:]
    out = np.empty((size + 3, size + 3))
    explained = projection.solved[:, :, :size].transpose(0, 2, 1) @ by_pose
    (left + explained).sum(axis=0, out=out[:size, :size])
    by_turn.sum(axis=0, out=out[size:, :size])
    (turn[:, :, :3] + turn[:, :, 3:] @ cross.transpose(0, 2, 1)).sum(axis=0, out=out[size:, size:])
    return out


def _observed_error_metric(turned: Array, points: float) -> Array:
    """Metric (p, p) of `Evidence` at so many points, of their `_turned_gram`."""
    total, by_turn, turns = turned[:-3, :-3], turned[-3:, :-3], turned[-3:, -3:]
    removed = by_turn.T @ solve_or_nan(turns, by_turn)
    metric: Array = (total - removed) / points
    return metric if np.isfinite(metric).all() else total


@dataclass(frozen=True, eq=False)
class Result:
    """Covariance (p, p) of the intrinsics, and information (p, p), the inverse at white noise of the corners.

    `inflation`: variance of projections / that at white noise, >= 1.
    """

    covariance: Array
    information: Array
    inflation: float


def estimate(evidence: Evidence, sigma: float, prior_information: Array | None = None) -> Result:
    """Estimate the covariance of the intrinsics at a noise `sigma`, px per coordinate; see the module.

    The information (p, p) of the intrinsics' prior is in units of 1 / sigma^2; None if it took no part.
    """
    size = len(evidence.metric)
    information, basis, whitened = _whitened(evidence.gram, size, prior_information)
    w, b = basis.T @ evidence.metric @ basis, whitened[:, :, :size] @ basis
    gram, pull = evidence.gram[:, size:, size:], whitened[:, :, size:]
    effects = EffectMoments.of(gram, pull[:, :, :-1], sigma)
    if evidence.of_effects is None:
        m, s = effects.variances()
    else:
        _, _, more = _whitened(evidence.of_effects, size, prior_information)
        wider = EffectMoments.of(evidence.of_effects[:, size:, size:], more[:, :, size:-1], sigma)
        m, s = wider.variances()
    bend_share = BEND_SHARE
    # Without a trace of either, as mostly under white noise, the rest is skipped.
    likely = EffectLikelihood.of(gram, pull, sigma) if m or s else None
    if likely is not None:
        m += trust(likely.motion_share) * max(likely.motion - m, 0.0)
        bend_share += trust(likely.bend_share) * (1 - bend_share)
    motion, bend = effects.covariances(m, s)
    working = b + motion
    total = working.sum(axis=0)
    h = whitened[:, :, -1] / sigma
    inflation = scatter_inflation(w, b, working, h)
    shape = np.eye(size) - b.sum(axis=0) + inflation * total + bend_share * bend
    covariance: Array = sigma**2 * basis @ shape @ basis.T
    white = float(np.trace(w))
    return Result(
        (covariance + covariance.T) / 2,
        information / sigma**2,
        max(dot(w, shape) / white, 1.0) if white > 0 else inflation,
    )


def _whitened(gram: Array, size: int, prior_information: Array | None) -> tuple[Array, Array, Array]:
    """Information (p, p), its whitening T (p, p), and T' times the rows (c, p, m) of the intrinsics."""
    information = gram[:, :size, :size].sum(axis=0)
    if prior_information is not None:
        information = information + prior_information
    basis = whitening(information)
    return information, basis, basis.T @ gram[:, :size]


def scatter_inflation(w: Array, b: Array, working: Array, h: Array) -> float:
    """Inflation by what is neither noise nor motion, of whitened matrices at unit noise.

    Metric (p, p), information (c, p, p), covariance of the gradients before the fit took its part (c, p, p),
    and gradients (c, p).
    """
    taken = b @ working
    q = working - taken - taken.transpose(0, 2, 1) + b @ working.sum(axis=0) @ b
    wq = w @ q
    expected = float(np.einsum("vii->", wq))
    if not expected > MIN_EXPECTED * float(np.trace(w)):
        return 1.0
    freedom = expected**2 / max(dot(wq, wq.transpose(0, 2, 1)), 1e-300)
    quotient = dot(w, h.T @ h) / expected
    return max((freedom * quotient + PRIOR_INFLATION_FREEDOM) / (freedom + PRIOR_INFLATION_FREEDOM), 1.0)


def same_pose_labels(poses: Poses, obs: Observations, used: Mask, focal_widths: float) -> IntArray:
    """Assign views in nearly the same pose to clusters (v,), numbered from 0.

    In their order, each joins the first view before it that is near and began a cluster: a slow movement
    makes several.
    """
    x, y = (obs.points[:, axis][used] for axis in (0, 1))
    left, right, low, high = x.min(), x.max(), y.min(), y.max()
    corners = np.array([[left, right, right, left], [low, low, high, high], [0.0] * 4])
    points = poses.camera_points(corners)
    middle = points.sum(axis=2)
    points *= (2 * focal_widths / np.sqrt((middle * middle).sum(axis=1)))[:, None, None]
    place = points.reshape(len(points), -1)
    near = _near(place)
    if near.sum() == len(near):
        return np.arange(len(near))
    labels = np.full(len(near), -1)
    for i in range(len(near)):
        if labels[i] < 0:
            labels[near[i] & (labels < 0)] = i
    return np.unique(labels, return_inverse=True)[1]


def _near(place: Array) -> Mask:
    """True (v, v) for rows (v, m) that are nearer to one another than SAME_POSE_WIDTHS."""
    square = np.sum(place**2, axis=1)
    out = np.empty((len(place), len(place)), dtype=bool)
    for first in range(0, len(place), MAX_BLOCK_ROWS):
        block = slice(first, first + MAX_BLOCK_ROWS)
        distance = square[block, None] + square - 2 * place[block] @ place.T
        out[block] = distance < SAME_POSE_WIDTHS**2
    np.fill_diagonal(out, True)
    return out
