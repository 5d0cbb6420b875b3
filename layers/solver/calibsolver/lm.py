"""Levenberg-Marquardt on intrinsics and poses, the poses eliminated.

Minimises sum rho(|r_i|) + sigma^2 |prior|^2, rho Huber's function or the square; sigma is the noise that the
residuals themselves show. (Marquardt 1963; Huber 1964; Triggs et al. 2000 for the elimination.)
"""

from dataclasses import dataclass, replace

import numpy as np

from . import normal, prior
from .arrays import Array
from .models import Model
from .normal import Poses
from .observations import Observations

RAYLEIGH_MEDIAN = 1.1774100225154747
"""Median of the length of a 2-vector of independent N(0, 1): sqrt(2 ln 2)."""
HUBER = 3.0
"""Residual length, in sigmas of one coordinate, from which a point counts less."""


@dataclass(frozen=True)
class Options:
    """How one run of the solver goes."""

    robust: bool = False
    with_prior: bool = True
    iterations: int = 60
    tolerance: float = 1e-10
    """Stop when a Gauss-Newton step promises a smaller relative decrease of the cost than this."""


@dataclass(frozen=True, eq=False)
class State:
    """Where the solver stands: intrinsics (p,), poses, residuals (v, 2, n) px and the Jacobian there."""

    k: Array
    poses: Poses
    r: Array
    j: Array
    converged: bool = False

    @property
    def length(self) -> Array:
        """Residual lengths (v, n), px."""
        return np.sqrt(self.r[:, 0] ** 2 + self.r[:, 1] ** 2)


def at(model: Model, obs: Observations, k: Array, poses: Poses) -> State:
    """Return the state at given intrinsics and poses."""
    q, j = normal.design(model, k, poses, obs.points)
    return State(k, poses, q - obs.pixels, j)


def noise(state: State, weights: Array) -> float:
    """Robust standard deviation of one coordinate of the residuals of points with weight, px."""
    length = state.length[weights > 0]
    used = length.size * 2
    unknowns = state.k.size + 6 * len(state.r)
    correction = np.sqrt(used / max(used - unknowns, 0.1 * used))
    return float(np.median(length) / RAYLEIGH_MEDIAN * correction)


def cost(
    model: Model, state: State, weights: Array, sigma: float, img_size: tuple[int, int], options: Options
) -> float:
    """Return the objective: px^2."""
    length = state.length
    if options.robust:
        delta = HUBER * sigma
        rho = np.where(length <= delta, length * length, delta * (2 * length - delta))
    else:
        rho = length * length
    total = float(np.sum(rho * weights))
    if options.with_prior:
        e, _ = prior.residuals(model, state.k, img_size)
        total += sigma * sigma * float(e @ e)
    return total


def solve(
    model: Model,
    obs: Observations,
    start: State,
    weights: Array,
    img_size: tuple[int, int],
    options: Options,
) -> State:
    """Iterate from `start` to the optimum for points of weight (v, n).

    `converged` is set where the gradient allows no further decrease; it is not where the iterations ran out.
    """
    size = model.size
    v, width, _, n = start.j.shape
    state, damping = start, 1e-4
    floor = 1e-6 * img_size[0]
    for _ in range(options.iterations):
        sigma = max(noise(state, weights), floor)
        w = weights
        if options.robust:
            w = weights * np.minimum(1, HUBER * sigma / np.maximum(state.length, 1e-30))
        root = np.sqrt(w)
        full = np.empty((v, width + 1, 2, n))
        np.multiply(state.j, root[:, None, None, :], out=full[:, :width])
        np.multiply(state.r, root[:, None, :], out=full[:, width])
        flat = full.reshape(v, width + 1, 2 * n)
        h = flat @ flat.transpose(0, 2, 1)
        a = h[:, :size, :size].sum(axis=0)
        g = h[:, :size, width].sum(axis=0)
        if options.with_prior:
            e, pj = prior.residuals(model, state.k, img_size)
            a = a + sigma * sigma * (pj.T @ pj)
            g = g + sigma * sigma * (pj.T @ e)
        here = cost(model, state, weights, sigma, img_size, options)
        b, gb = h[:, size:width, size:width], h[:, size:width, width]
        c = h[:, size:width, :size]
        diagonal_b = np.diagonal(b, axis1=1, axis2=2)
        scale_b = 1 / np.sqrt(diagonal_b + 1e-13 * diagonal_b.max(axis=1, keepdims=True) + 1e-200)
        unit = b * scale_b[:, :, None] * scale_b[:, None, :]
        cs = np.concatenate([c, gb[:, :, None]], axis=2) * scale_b[:, :, None]
        scale_a = 1 / np.sqrt(np.diagonal(a) + 1e-200)
        while True:
            solved = np.linalg.solve(unit + (damping + 1e-14) * np.eye(6), cs)
            reduced = a - np.einsum("vij,vik->jk", cs[:, :, :size], solved[:, :, :size])
            gradient = g - np.einsum("vij,vi->j", cs[:, :, :size], solved[:, :, size])
            lhs = reduced * scale_a[:, None] * scale_a + (damping + 1e-14) * np.eye(size)
            dk = -scale_a * np.linalg.solve(lhs, scale_a * gradient)
            step = -scale_b * (solved[:, :, size] + np.einsum("vij,j->vi", solved[:, :, :size], dk))
            promised = -(float(g @ dk) + float(np.sum(gb * step)))
            if promised <= options.tolerance * here:
                return replace(state, converged=bool(np.isfinite(promised)))
            moved = (
                at(model, obs, state.k + dk, state.poses.moved(step))
                if (state.k + dk)[:2].min() > 0
                else None
            )
            if moved is not None:
                there = cost(model, moved, weights, sigma, img_size, options)
                if there < here:
                    state, damping = moved, max(damping * 0.1, 1e-12)
                    break
            damping = max(damping, 1e-8) * 10
            if damping > 1e8:
                return state
    return state
