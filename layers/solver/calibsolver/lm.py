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

FINEST = 4e-5
"""Noise of one coordinate / image width that no detector undercuts."""
UNSEEN = 1e-5
"""Decrease of the cost, in squares of sigma, a three-hundredth of a standard deviation from the optimum."""
KEPT = 0.25
"""Share of the promised decrease below which the next step is a shorter one."""


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
    """Where the solver stands.

    Attributes
    ----------
    k, poses
        Intrinsics (p,) and poses.
    r, length
        Residuals (v, 2, n) and their lengths (v, n), px.
    j
        Jacobian (v, p + 6, 2, n) of the residuals.
    belief, belief_j
        Whitened residuals (m,) of the prior and their Jacobian (m, p).
    converged
        Whether the gradient allows no further decrease.
    """

    k: Array
    poses: Poses
    r: Array
    length: Array
    j: Array
    belief: Array
    belief_j: Array
    converged: bool = False


@dataclass(frozen=True, eq=False)
class Problem:
    """What is fitted: a model to observations of one camera."""

    model: Model
    obs: Observations
    img_size: tuple[int, int]

    def at(self, k: Array, poses: Poses) -> State:
        """Return the state at given intrinsics and poses."""
        q, j = normal.design(self.model, k, poses, self.obs.points)
        r = q - self.obs.pixels
        length = np.sqrt(r[:, 0] ** 2 + r[:, 1] ** 2)
        return State(k, poses, r, length, j, *prior.residuals(self.model, k, self.img_size))

    def solve(self, state: State, weights: Array, options: Options) -> State:
        """Iterate from `state` to the optimum for points of weight (v, n).

        The result is `converged` where the gradient allows no further decrease, and is not where no step led
        downhill, or the iterations ran out before what the gradient still promised was too little to see.
        """
        damping, floor = 1e-4, 1e-6 * self.img_size[0]
        # Below a billionth of the image per point it is rounding that is fitted.
        least = self.obs.count * (1e-9 * self.img_size[0]) ** 2
        promised = sigma = np.inf
        for _ in range(options.iterations):
            sigma = max(noise(state, weights), floor)
            here = cost(state, weights, sigma, options)
            system = System.of(state, weights, sigma, options)
            while True:
                dk, step, promised = system.step(damping)
                if not promised > options.tolerance * here + least:
                    return replace(state, converged=bool(np.isfinite(promised)))
                k = state.k + dk
                if k[:2].min() > 0:
                    moved = self.at(k, state.poses.moved(step))
                    gained = here - cost(moved, weights, sigma, options)
                    if gained > 0:
                        state = moved
                        # A step that keeps little of its promise went from one side of a valley to the other.
                        damping = (
                            max(damping * 0.1, 1e-12) if gained > KEPT * promised else 10 * max(damping, 1e-8)
                        )
                        break
                damping = max(damping, 1e-8) * 10
                if damping > 1e8:
                    return state
        seen = max(sigma, FINEST * self.img_size[0])
        # Where curvature beyond Gauss-Newton's makes it slow, what is left may be nothing that could be seen.
        return replace(state, converged=bool(promised < UNSEEN * seen * seen))


@dataclass(frozen=True, eq=False)
class System:
    """Normal equations at one state, each unknown scaled to a unit diagonal (Marquardt's scaling).

    Attributes
    ----------
    a, ga
        Intrinsics, (p, p), and their gradient (p,).
    b
        Poses, (v, 6, 6).
    c
        Poses by intrinsics, and the gradient of the poses, (v, 6, p + 1).
    scale_a, scale_b
        What the steps are multiplied by, (p,) and (v, 6).
    """

    a: Array
    ga: Array
    b: Array
    c: Array
    scale_a: Array
    scale_b: Array

    @classmethod
    def of(cls, state: State, weights: Array, sigma: float, options: Options) -> "System":
        """Build the system for points of weight (v, n), Huber's weights on top where the run is robust."""
        v, width, _, n = state.j.shape
        size = width - 6
        if options.robust:
            weights = weights * np.minimum(1, HUBER * sigma / np.maximum(state.length, 1e-30))
        root = np.sqrt(weights)
        full = np.empty((v, width + 1, 2, n))
        np.multiply(state.j, root[:, None, None, :], out=full[:, :width])
        np.multiply(state.r, root[:, None, :], out=full[:, width])
        flat = full.reshape(v, width + 1, 2 * n)
        h = flat @ flat.transpose(0, 2, 1)
        total = h[:, :size].sum(axis=0)
        a, ga = total[:, :size], total[:, width]
        if options.with_prior:
            a = a + sigma * sigma * (state.belief_j.T @ state.belief_j)
            ga = ga + sigma * sigma * (state.belief_j.T @ state.belief)
        b = h[:, size:width, size:width]
        diagonal = np.diagonal(b, axis1=1, axis2=2)
        scale_b = 1 / np.sqrt(diagonal + 1e-13 * diagonal.max(axis=1, keepdims=True) + 1e-200)
        scale_a = 1 / np.sqrt(np.diagonal(a) + 1e-200)
        c = np.concatenate([h[:, size:width, :size] * scale_a, h[:, size:width, width:]], axis=2)
        return cls(
            a * scale_a[:, None] * scale_a,
            ga * scale_a,
            b * scale_b[:, :, None] * scale_b[:, None, :],
            c * scale_b[:, :, None],
            scale_a,
            scale_b,
        )

    def step(self, damping: float) -> tuple[Array, Array, float]:
        """Solve for the steps of intrinsics (p,) and poses (v, 6), and the decrease that they promise."""
        size = len(self.a)
        lift = damping + 1e-14
        solved = np.linalg.solve(self.b + lift * np.eye(6), self.c)
        flat = self.c[:, :, :size].reshape(-1, size)
        removed = flat.T @ solved.reshape(-1, size + 1)
        lhs = self.a - removed[:, :size] + lift * np.eye(size)
        dk = -np.linalg.solve(lhs, self.ga - removed[:, size])
        dp = -(solved[:, :, size] + solved[:, :, :size] @ dk)
        promised = -float(self.ga @ dk) - float(np.sum(self.c[:, :, size] * dp))
        return dk * self.scale_a, dp * self.scale_b, promised


def noise(state: State, weights: Array) -> float:
    """Robust standard deviation of one coordinate of the residuals of points with weight, px."""
    length = state.length[weights > 0]
    used = length.size * 2
    unknowns = state.k.size + 6 * len(state.r)
    correction = np.sqrt(used / max(used - unknowns, 0.1 * used))
    middle = np.partition(length, length.size // 2)[length.size // 2]
    return float(middle / RAYLEIGH_MEDIAN * correction)


def cost(state: State, weights: Array, sigma: float, options: Options) -> float:
    """Return the objective, px^2."""
    length = state.length
    if options.robust:
        delta = HUBER * sigma
        rho = np.where(length <= delta, length * length, delta * (2 * length - delta))
    else:
        rho = length * length
    total = float(np.sum(rho * weights))
    if options.with_prior:
        total += sigma * sigma * float(state.belief @ state.belief)
    return total
