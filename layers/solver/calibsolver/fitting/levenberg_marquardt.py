"""Levenberg-Marquardt on intrinsics and poses, the poses eliminated.

Minimises sum rho(|r_i|) + sigma^2 |prior|^2, rho Huber's function or the square; sigma is the noise that the
residuals themselves show. (Marquardt 1963; Huber 1964; Triggs et al. 2000 for the elimination; Transtrum &
Sethna 2012 for the second order along narrow valleys.)
"""

from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array, Mask
from ..models import Model
from . import normal_equations, prior
from .normal_equations import Poses
from .observations import Observations

RAYLEIGH_MEDIAN = 1.1774100225154747
"""Median of the length of a 2-vector of independent N(0, 1): sqrt(2 ln 2)."""
HUBER = 3.0
"""Residual length, in sigmas of one coordinate, from which a point counts less."""

FINEST = 4e-5
"""Noise of one coordinate / image width that no detector undercuts."""
ROUNDING = 1e-11
"""Residual / image width below which it is rounding that is fitted."""
CLOSE = 1e-3
"""Relative decrease of the cost from which promises fall as fast as they did last: what the next one would be
is then known without asking."""
UNSEEN = 1e-5
"""Decrease of the cost, in squares of sigma, a three-hundredth of a standard deviation from the optimum."""
KEPT = 0.25
"""Share of the promised decrease below which the next step is a shorter one."""
WINDING = 6
"""Iterations after which the valley is taken for a winding one."""
BENT = 0.75
"""The second-order part of a step may be as long as this share of the first: else neither is trusted."""


@dataclass(frozen=True)
class Options:
    """How one run of the solver goes."""

    robust: bool = False
    with_prior: bool = True
    iterations: int = 160
    tolerance: float = 1e-10
    """Stop when a Gauss-Newton step promises a smaller relative decrease of the cost than this."""
    damping: float = 1e-8
    """Of the first step: hardly any where the optimum is near."""


@dataclass(frozen=True, eq=False)
class State:
    """Where the solver stands.

    Attributes
    ----------
    k, poses
        Intrinsics (p,) and poses.
    rows
        (p + 7, 2, v, n): the Jacobian of the residuals by intrinsics and pose, and in the last row the
        residuals themselves, px.
    square
        Squared lengths (v, n) of the residuals, px^2.
    belief, belief_j
        Whitened residuals (m,) of the prior and their Jacobian (m, p).
    converged
        Whether the gradient allows no further decrease.
    """

    k: Array
    poses: Poses
    rows: Array
    square: Array
    belief: Array
    belief_j: Array
    converged: bool = False

    @property
    def length(self) -> Array:
        """Lengths (v, n) of the residuals, px."""
        out: Array = np.sqrt(self.square)
        return out

    @property
    def finite(self) -> bool:
        """Whether every residual is a number."""
        return bool(np.isfinite(self.square).all())


@dataclass(frozen=True, eq=False)
class Objective:
    """What a run minimises: weights (v, n) of the points, Huber's limit (px, or inf), weight of the prior."""

    weights: Array | None
    limit: float
    belief: float

    def of(self, state: State) -> tuple[float, Array | None]:
        """Value at `state`, px^2, and the weights (v, n) of the squares there; None: all are 1."""
        weights: Array | None
        if self.limit < np.inf:
            share: Array = np.minimum(1.0, self.limit / np.sqrt(np.maximum(state.square, 1e-300)))
            rho = state.square * share * (2 - share)
            weights = share if self.weights is None else share * self.weights
        else:
            weights, rho = self.weights, state.square
        total = float(rho.sum()) if self.weights is None else float(np.vdot(rho, self.weights))
        return total + self.belief * float(state.belief @ state.belief), weights


@dataclass(frozen=True, eq=False)
class Problem:
    """What is fitted: a model to observations of one camera."""

    model: Model
    obs: Observations
    img_size: tuple[int, int]

    def possible(self, k: Array) -> bool:
        """Whether the model has a picture at all with intrinsics k (p,)."""
        return bool(k[0] > 0 and k[1] > 0 and self.model.magnification(k[4:])[0] > 0)

    def at(self, k: Array, poses: Poses) -> State:
        """Return the state at given intrinsics and poses."""
        q, rows = normal_equations.linearise(self.model, k, poses, self.obs.points, 1)
        r = rows[-1]
        np.subtract(q, self.obs.pixels.transpose(1, 0, 2), out=r)
        square = r[0] * r[0] + r[1] * r[1]
        return State(k, poses, rows, square, *prior.residuals(self.model, k, self.img_size))

    def solve(self, state: State, weights: Array, options: Options) -> State:
        """Iterate from `state` to the optimum for points of weight (v, n).

        The result is `converged` where the gradient allows no further decrease, and is not where no step led
        downhill, or the iterations ran out before what the gradient still promised was too little to see.
        """
        damping, floor = options.damping, 1e-6 * self.img_size[0]
        plain = None if (weights == 1).all() else weights
        counted = weights > 0.5
        least = self.obs.count * (ROUNDING * self.img_size[0]) ** 2
        promised = sigma = before = np.inf
        for i in range(options.iterations):
            sigma = max(noise(state, counted), floor)
            objective = Objective(
                plain, HUBER * sigma if options.robust else np.inf, sigma * sigma * options.with_prior
            )
            here, share = objective.of(state)
            system = System.of(state, share, objective.belief)
            while True:
                dk, step, promised = system.step(damping)
                little = options.tolerance * here + least
                if not promised > little:
                    return replace(state, converged=bool(np.isfinite(promised)))
                if i >= WINDING:
                    dk, step = self.bent(state, system, share, dk, step, damping)
                k = state.k + dk
                if self.possible(k):
                    moved = self.at(k, state.poses.moved(step))
                    gained = here - objective.of(moved)[0]
                    if gained > 0:
                        if before < CLOSE * here and promised * (promised / before) < little and i < WINDING:
                            return replace(moved, converged=True)
                        state, before = moved, promised
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

    def bent(
        self, state: State, system: "System", share: Array | None, dk: Array, step: Array, damping: float
    ) -> tuple[Array, Array]:
        """Add the second-order part to a step (p,) and (v, 6): along a curve instead of a straight line."""
        ahead = 0.1
        k = state.k + ahead * dk
        if not self.possible(k):
            return dk, step
        q = normal_equations.project(self.model, k, state.poses.moved(ahead * step), self.obs.points)
        rows, r, size = state.rows, state.rows[-1], self.model.size
        straight = np.tensordot(dk, rows[:size], 1) + np.einsum("vi,iavn->avn", step, rows[size:-1])
        curve = 2 / ahead * (((q - self.obs.pixels).transpose(1, 0, 2) - r) / ahead - straight)
        weighted = curve if share is None else curve * share
        if not np.isfinite(weighted).all():
            return dk, step
        gk = np.tensordot(rows[:size], weighted, 3)
        gp = np.einsum("iavn,avn->vi", rows[size:-1], weighted)
        ck, cp = system.towards(gk, gp, damping)
        long, longer = system.length(ck, cp), system.length(dk, step)
        if not long <= 2 * BENT * longer:
            return dk, step
        return dk + ck / 2, step + cp / 2


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
    def of(cls, state: State, weights: Array | None, belief: float) -> "System":
        """Build the system for points of weight (v, n), and the prior's weight."""
        size = len(state.k)
        h = normal_equations.squared(state.rows if weights is None else state.rows * np.sqrt(weights))
        total = h[:, :size].sum(axis=0)
        a, ga = total[:, :size], total[:, -1]
        if belief:
            weighted = belief * state.belief_j.T
            a = a + weighted @ state.belief_j
            ga = ga + weighted @ state.belief
        scale_a = 1 / np.sqrt(a.diagonal() + 1e-200)
        diagonal = np.diagonal(h, axis1=1, axis2=2)[:, size:-1]
        scale_b = 1 / np.sqrt(diagonal + 1e-13 * diagonal.max(axis=1, keepdims=True) + 1e-200)
        b = h[:, size:-1, size:-1] * scale_b[:, :, None] * scale_b[:, None, :]
        c = np.empty((len(b), 6, size + 1))
        np.multiply(h[:, size:-1, :size], scale_a, out=c[:, :, :size])
        c[:, :, size] = h[:, size:-1, -1]
        c *= scale_b[:, :, None]
        return cls(a * scale_a[:, None] * scale_a, ga * scale_a, b, c, scale_a, scale_b)

    def step(self, damping: float) -> tuple[Array, Array, float]:
        """Solve for the steps of intrinsics (p,) and poses (v, 6), and the decrease that they promise."""
        dk, dp = self._solve(self.ga, self.c, damping)
        promised = -float(self.ga @ dk) - float(np.vdot(self.c[:, :, -1], dp))
        return dk * self.scale_a, dp * self.scale_b, promised

    def towards(self, gk: Array, gp: Array, damping: float) -> tuple[Array, Array]:
        """Take the steps (p,) and (v, 6) down another gradient, (p,) and (v, 6)."""
        c = self.c.copy()
        c[:, :, -1] = gp * self.scale_b
        dk, dp = self._solve(gk * self.scale_a, c, damping)
        return dk * self.scale_a, dp * self.scale_b

    def length(self, dk: Array, dp: Array) -> float:
        """Length of a step in the scaled unknowns."""
        return float(np.hypot(np.linalg.norm(dk / self.scale_a), np.linalg.norm(dp / self.scale_b)))

    def _solve(self, ga: Array, c: Array, damping: float) -> tuple[Array, Array]:
        size = len(self.a)
        lift = damping + 1e-14
        solved = solution(self.b + lift * EYE, c)
        removed = c[:, :, :size].reshape(-1, size).T @ solved.reshape(-1, size + 1)
        lhs = self.a - removed[:, :size]
        lhs.flat[:: size + 1] += lift
        dk: Array = np.negative(solution(lhs, ga - removed[:, size]))
        dp: Array = np.negative(solved[:, :, size] + solved[:, :, :size] @ dk)
        return dk, dp


EYE = np.eye(6)


def solution(a: Array, b: Array) -> Array:
    """Solve a x = b; NaN, a step that nobody takes, where there is no solution."""
    try:
        return np.asarray(np.linalg.solve(a, b), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.full(b.shape, np.nan)


def noise(state: State, counted: Mask) -> float:
    """Robust standard deviation of one coordinate of the residuals of points that count (v, n), px.

    Infinite where none does.
    """
    square = state.square[counted] if not counted.all() else state.square.reshape(-1)
    if not square.size:
        return np.inf
    used = square.size * 2
    unknowns = state.k.size + 6 * len(state.square)
    correction = np.sqrt(used / max(used - unknowns, 0.1 * used))
    middle = np.sqrt(np.partition(square, square.size // 2)[square.size // 2])
    return float(middle / RAYLEIGH_MEDIAN * correction)
