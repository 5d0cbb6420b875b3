"""Levenberg-Marquardt on intrinsics and poses, the poses eliminated (bundle adjustment).

Minimises sum rho(|r_i|) + sigma^2 |prior|^2 by iteratively reweighted least squares; rho is Huber's function
or the square, sigma the noise that the residuals show. (Marquardt 1963; Huber 1964; Triggs et al. 2000 for
the elimination; Transtrum & Sethna 2012 for the geodesic acceleration along narrow valleys.)
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from .. import deadline, rotation
from ..arrays import Array, Mask
from ..models import Model
from . import normal_equations, prior, systematic_effects
from .normal_equations import POSE_SIZE, Elimination, Poses, System
from .observations import Observations

RAYLEIGH_MEDIAN = 1.1774100225154747
"""sqrt(2 ln 2), median length of a 2-vector of independent N(0, 1)."""
HUBER_SIGMAS = 3.0

NOISE_FLOOR = 4e-5
"""Noise of one coordinate / image width that no detector undercuts."""
ROUNDOFF = 1e-11
"""Residual / image width that is rounding."""
EXTRAPOLATE_BELOW = 1e-3
"""Relative decrease of the cost from which predicted decreases are taken to fall as fast as they did last."""
NEGLIGIBLE_DECREASE = 1e-5
"""Decrease of the cost, in squares of sigma: a three-hundredth of a standard deviation from the optimum."""
UNDAMPED = 1e-8
MIN_GAIN_RATIO = 0.25
MIN_DAMPING, MIN_RAISED_DAMPING, MAX_DAMPING = 1e-12, 1e-8, 1e8
"""Bounds of the damping: when lowered, when raised, and the one beyond which no step leads downhill."""
SAME_STEP = 0.99
"""Predicted decrease / that of a step that led far uphill, from which they are nearly the same step."""
NEAR_OPTIMUM = 1e-2
"""Predicted relative decrease of the cost from which `Step.correct` applies."""
MIN_ALIGNMENT, MAX_SHARE = 0.5, 0.8
"""Share of a step's curvature that lies along the one before, at least, and quotient of both, at most."""
MIN_CURVATURE_RATIO = 0.2
"""Curvature of the cost / of its normal equations along a step, at least; at most its inverse."""
MAX_ACCELERATION_RATIO = 0.75
"""Length of the geodesic acceleration / length of the step, at most."""
SHORT_STEP = 1e-6
"""Relative change of the focal length up to which a straight step is as good as a curved one."""
LONG_STEP = 700.0
"""Step from which it is straight: its exponential overflows."""
FINITE_DIFFERENCE = 0.1
"""Share of a step over which the second derivative is taken."""

# glibc returns freed blocks of more than 128 KB to the system until it has seen a larger one freed. To map
# the pages of every linearization again costs a tenth of a fit.
np.empty(2**21)


@dataclass(frozen=True)
class Options:
    """Options of one run of the solver."""

    robust: bool = False
    with_prior: bool = True
    iterations: int = 160
    tolerance: float = 1e-10
    """Relative decrease that a Gauss-Newton step predicts, below which the run ends."""
    damping: float = 1e-8
    """Of the first step."""
    one_step: bool = False
    """End also when actual and predicted decrease of an undamped step differ by less than the tolerance."""
    patient: bool = False
    """Lower the damping to its geometric mean with the last rejected damping: for curved valleys."""


@dataclass(frozen=True, eq=False)
class State:
    """Intrinsics and poses with the residuals and derivatives there.

    Attributes
    ----------
    rows
        (a + 7, 2, v, n): the Jacobian by the free intrinsics and the pose; the last row is the residuals, px.
    square
        Squared lengths (v, n) of the residuals, px^2.
    prior_residuals, prior_jacobian
        Whitened residuals (m,) of the prior and their Jacobian (m, a).
    converged
        True if the gradient allows no further decrease.
    """

    k: Array
    poses: Poses
    rows: Array
    square: Array
    prior_residuals: Array
    prior_jacobian: Array
    converged: bool = False

    @property
    def is_finite(self) -> bool:
        """True if every residual is finite."""
        return bool(np.isfinite(self.square).all())


@dataclass(frozen=True, eq=False)
class Objective:
    """Cost function: weights (v, n) of the points, Huber's delta (px, or inf), weight of the prior (px^2)."""

    weights: Array | None
    huber_delta: float
    prior_weight: float

    def of(self, state: State) -> tuple[float, Array | None]:
        """Value, px^2, and the weights (v, n) of the squares at `state`; None: all are 1."""
        weights, rho = self.weights, state.square
        if self.huber_delta < np.inf:
            irls_weights: Array = np.minimum(
                1.0, self.huber_delta / np.sqrt(np.maximum(state.square, 1e-300))
            )
            rho = state.square * irls_weights * (2 - irls_weights)
            weights = irls_weights if self.weights is None else irls_weights * self.weights
        total = float(rho.sum()) if self.weights is None else float(np.vdot(rho, self.weights))
        return total + self.prior_weight * float(state.prior_residuals @ state.prior_residuals), weights

    def prior_of(self, state: State) -> tuple[Array, Array] | None:
        """Information (a, a) and half gradient (a,) of the prior; None: it has no weight."""
        weighted = self.prior_weight * state.prior_jacobian.T
        return (
            (weighted @ state.prior_jacobian, weighted @ state.prior_residuals) if self.prior_weight else None
        )


@dataclass(frozen=True, eq=False)
class Step:
    """Undamped step (a,) and (v, 6), by which the next one is corrected.

    Gauss-Newton's normal equations lack the curvature of the residuals, and reweighting that of Huber's
    function. So near the optimum each step errs by the same share as the one before, and the gradients before
    and after a step give the true curvature along it (the secant equation).

    `slope` and `curvature` are halves of the first and second derivative of the predicted cost along it.
    """

    da: Array
    dp: Array
    predicted: float
    slope: float
    curvature: float

    def correct(self, after: "Step", system: System) -> "Step | None":
        """Correct the Gauss-Newton step `after` this one; None if it does not go along this one."""
        if not self.curvature > 0:
            return None
        slope = system.slope(self.da, self.dp)
        share, ratio = -slope / self.curvature, (slope - self.slope) / self.curvature
        if not (
            share * share * self.curvature > MIN_ALIGNMENT * after.curvature
            and abs(share) < MAX_SHARE
            and MIN_CURVATURE_RATIO < ratio < 1 / MIN_CURVATURE_RATIO
        ):
            return None
        more = share * (1 / ratio - 1)
        return Step(
            after.da + more * self.da,
            after.dp + more * self.dp,
            after.predicted - more * slope,
            after.slope + more * slope,
            after.curvature + more * (2 * share + more) * self.curvature,
        )


class LeastSquares(ABC):
    """Least squares in unknowns k (p,) that all views share, a of them free, and in the pose in each view.

    `straight_iterations`: iterations after which the valley is taken for a curved one.
    """

    obs: Observations
    straight_iterations: ClassVar[int] = 6

    @property
    @abstractmethod
    def width(self) -> int:
        """Width of an image, px: the scale of what is negligible."""

    @abstractmethod
    def is_feasible(self, k: Array) -> bool:
        """True if there is an image with k (p,)."""

    @property
    @abstractmethod
    def row_positions(self) -> Array:
        """Rows (v, n) of the points in their images, as `systematic_effects.row_position`."""

    @abstractmethod
    def prior(self, k: Array) -> tuple[Array, Array]:
        """Whitened residuals (m,) of the prior at k (p,), and their Jacobian (m, a)."""

    @abstractmethod
    def rows_of(self, k: Array, poses: Poses, obs: Observations, before: int = 0) -> tuple[Array, Array]:
        """Rows of a `State` after so many empty ones, and squared lengths (v, n)."""

    @abstractmethod
    def residuals_of(self, k: Array, poses: Poses, obs: Observations) -> Array:
        """Residuals (2, v, n), px."""

    def at(self, k: Array, poses: Poses) -> State:
        """Linearize at k (p,) and poses."""
        rows, square = self.rows_of(k, poses, self.obs)
        return State(k, poses, rows, square, *self.prior(k))

    def solve(self, state: State, weights: Array | Mask, options: Options) -> State:
        """Iterate from `state` to the optimum for points of weight (v, n).

        The result is not `converged` if no step led downhill, or if the iterations ran out before the
        predicted decrease was negligible.
        """
        damping, sigma_floor = options.damping, 1e-6 * self.width
        plain = None if (weights == 1).all() else weights.astype(np.float64)
        counted = weights > 0.5
        tolerance_abs = self.obs.count * (ROUNDOFF * self.width) ** 2
        predicted = sigma = previous_predicted = np.inf
        refused, last = 0.0, None
        for iteration in range(options.iterations):
            deadline.check()
            sigma = max(self.noise(state, counted), sigma_floor)
            objective = Objective(
                plain, HUBER_SIGMAS * sigma if options.robust else np.inf, sigma * sigma * options.with_prior
            )
            cost, irls_weights = objective.of(state)
            system = System.of(state.rows, irls_weights, objective.prior_of(state))
            tolerance = options.tolerance * cost + tolerance_abs
            curved = iteration >= self.straight_iterations
            uphill = np.inf
            while True:
                if damping > MAX_DAMPING:
                    return state
                da, dp, predicted, elimination = system.step(damping)
                if not predicted > tolerance:
                    return replace(state, converged=bool(np.isfinite(predicted)))
                if predicted > SAME_STEP * uphill and not curved:
                    refused, damping = damping, damping * 10
                    continue
                step = Step(da, dp, predicted, -predicted, predicted)
                is_near = damping <= UNDAMPED and predicted < NEAR_OPTIMUM * cost
                like_last = last.correct(step, system) if last is not None and is_near else None
                accelerated = curved and like_last is None
                if like_last is not None:
                    step = like_last
                elif curved:
                    da, dp = self._geodesic_acceleration(state, system, irls_weights, da, dp, elimination)
                    step = Step(da, dp, predicted, system.slope(da, dp), system.curvature(da, dp))
                moved = self._take_step(state, step.da, step.dp)
                actual = -np.inf if moved is None else cost - objective.of(moved)[0]
                used = damping
                accepted, damping = assess_step(damping, actual, step.predicted)
                if moved is not None and accepted:
                    break
                refused, last = used, None
                uphill = predicted if actual < -predicted else np.inf
            if options.patient and damping < used:
                damping = max(damping, float(np.sqrt(used * refused)))
                refused *= 0.1
            # The decrease that the next step would predict, extrapolated.
            following = predicted * (predicted / previous_predicted)
            if not accelerated and (
                (previous_predicted < EXTRAPOLATE_BELOW * cost and following < tolerance)
                # The error of the quadratic model bounds what the next step can gain.
                or (options.one_step and used <= UNDAMPED and abs(actual - step.predicted) < tolerance)
            ):
                return replace(moved, converged=True)
            last = step if used <= UNDAMPED else None
            state, previous_predicted = moved, predicted
        visible = max(sigma, NOISE_FLOOR * self.width)
        # Slow by curvature beyond Gauss-Newton's, it may have come so close that no difference is visible.
        return replace(state, converged=bool(predicted < NEGLIGIBLE_DECREASE * visible * visible))

    def noise(self, state: State, counted: Mask) -> float:
        """Noise of a coordinate, px, over the points that count (v, n): weight of the prior."""
        return robust_sigma(state, counted)

    def free(self, da: Array) -> Array:
        """Change (p,) of k by a step (a,) of the free unknowns."""
        return da

    def _take_step(self, state: State, da: Array, dp: Array) -> State | None:
        """Linearize after steps (a,) and (v, 6); None if there is no image."""
        k, poses = self.retract(state.k, state.poses, da, dp)
        return self.at(k, poses) if self.is_feasible(k) else None

    def retract(self, k: Array, poses: Poses, da: Array, dp: Array) -> tuple[Array, Poses]:
        """Change k (p,) and poses by steps (a,) and (v, 6)."""
        return k + self.free(da), poses.retract(dp)

    def _geodesic_acceleration(
        self, state: State, system: System, weights: Array | None, da: Array, dp: Array, at: Elimination
    ) -> tuple[Array, Array]:
        """Add the geodesic acceleration to steps (a,) and (v, 6), by a finite difference of the residuals."""
        h = FINITE_DIFFERENCE
        k, poses = self.retract(state.k, state.poses, h * da, h * dp)
        if not self.is_feasible(k):
            return da, dp
        moved = self.residuals_of(k, poses, self.obs)
        rows, r, size = state.rows, state.rows[-1], len(da)
        first = (da @ rows[:size].reshape(size, -1)).reshape(r.shape)
        first += np.einsum("vi,iavn->avn", dp, rows[size:-1])
        second = 2 / h * ((moved - r) / h - first)
        weighted = second if weights is None else second * weights
        if not np.isfinite(weighted).all():
            return da, dp
        g_c = rows[:size].reshape(size, -1) @ weighted.reshape(-1)
        g_p = np.einsum("iavn,avn->vi", rows[size:-1], weighted)
        acceleration_c, acceleration_p = system.solve_with_gradient(g_c, g_p, at)
        length, longest = system.length(acceleration_c, acceleration_p), system.length(da, dp)
        if not length <= 2 * MAX_ACCELERATION_RATIO * longest:
            return da, dp
        return da + acceleration_c / 2, dp + acceleration_p / 2


@dataclass(frozen=True, eq=False)
class Problem(LeastSquares):
    """A model to be fitted to observations of one camera.

    The intrinsics may go in the directions T of the `basis` (p, a), k + T da; None: all are free. `origin`
    (p,) satisfies the constraint of the basis; None: every start does.
    """

    model: Model
    obs: Observations
    img_size: tuple[int, int]
    basis: Array | None = None
    origin: Array | None = None
    straight_iterations: ClassVar[int] = 4

    @property
    def width(self) -> int:
        """Width of the image, px."""
        return self.img_size[0]

    def is_feasible(self, k: Array) -> bool:
        """True if the model has an image with intrinsics k (p,)."""
        return bool(k[0] > 0 and k[1] > 0 and self.model.magnification(k[4:])[0] > 0)

    @property
    def directions(self) -> Array:
        """Free directions (p, a) of the intrinsics."""
        return np.eye(self.model.size) if self.basis is None else self.basis

    def focal_widths(self, k: Array) -> float:
        """Focal length at the axis along x / image width."""
        return float(self.model.focal(k)[0]) / self.width

    @property
    def row_positions(self) -> Array:
        """Rows (v, n) of the points."""
        return systematic_effects.row_position(self.obs.pixels[:, 1], self.img_size[1])

    def rows_of(self, k: Array, poses: Poses, obs: Observations, before: int = 0) -> tuple[Array, Array]:
        """Rows and squared lengths, see `LeastSquares`."""
        rows, square = residual_rows(self.model, k, poses, obs, before)
        if self.basis is None:
            return rows, square
        after = before + self.model.size
        free = np.tensordot(self.basis.T, rows[before:after], 1)
        return np.concatenate([rows[:before], free, rows[after:]]), square

    def prior(self, k: Array) -> tuple[Array, Array]:
        """Residuals (m,) and Jacobian (m, a), see `LeastSquares`."""
        r, j = prior.residuals(self.model, k, self.img_size)
        return r, j if self.basis is None else j @ self.basis

    def nearest(self, k: Array) -> Array:
        """Intrinsics (p,) near to k (p,) that satisfy the constraint."""
        if self.basis is None or self.origin is None:
            return k
        return self.origin + self.basis @ np.linalg.lstsq(self.basis, k - self.origin, rcond=None)[0]

    def residuals_of(self, k: Array, poses: Poses, obs: Observations) -> Array:
        """Residuals (2, v, n), px."""
        p = poses.camera_points(obs.points).transpose(1, 0, 2)
        r = self.model.project(k, p) - obs.pixels.transpose(1, 0, 2)
        return r if obs.scale is None else r * obs.scale

    def free(self, da: Array) -> Array:
        """Change (p,) of the intrinsics by a step (a,)."""
        return da if self.basis is None else self.basis @ da

    def retract(self, k: Array, poses: Poses, da: Array, dp: Array) -> tuple[Array, Poses]:
        """Change intrinsics and poses along the curve that keeps the picture.

        A longer focal length moves the boards away and leaves each coefficient's effect in px: the valley
        between focal length, distortion and distance is then nearly straight. A constraint is kept by
        straight steps.
        """
        if self.origin is not None:
            return super().retract(k, poses, da, dp)
        change = self.free(da)
        moved, t = k + change, poses.t + dp[:, 3:]
        magnified, by_d = self.model.magnification(k[4:])
        lens = float(by_d @ change[4:]) / magnified
        across, down = float(change[0] / k[0]), float(change[1] / k[1])
        stretched, longer = (across + down) / 2, (across + down) / 2 + lens
        is_short = max(abs(stretched), abs(longer)) <= SHORT_STEP
        if not is_short and max(abs(across), abs(down)) + abs(lens) < LONG_STEP:
            order, grown = 2 * prior.weights(self.model).order, math.exp(longer)
            moved[4:] = (moved[4:] - k[4:] * (order * stretched)) * math.exp(stretched) ** order
            shrunk = magnified / self.model.magnification(moved[4:])[0]
            moved[0], moved[1] = (
                k[0] * math.exp(across + lens) * shrunk,
                k[1] * math.exp(down + lens) * shrunk,
            )
            t[:, 2] = (t[:, 2] - poses.t[:, 2] * longer) * grown
        return moved, Poses(rotation.matrix(dp[:, :3]) @ poses.r, t)


def residual_rows(
    model: Model, k: Array, poses: Poses, obs: Observations, rows_before: int = 0
) -> tuple[Array, Array]:
    """Weighted Jacobian and residuals (p + 7, 2, v, n), px, after `rows_before` empty rows.

    Also returns the residuals' squared lengths (v, n), px^2.
    """
    q, rows = normal_equations.linearize(model, k, poses, obs.points, 1, rows_before)
    r = rows[-1]
    np.subtract(q, obs.pixels.transpose(1, 0, 2), out=r)
    if obs.scale is not None:
        rows[rows_before:] *= obs.scale
    return rows, r[0] * r[0] + r[1] * r[1]


def assess_step(damping: float, actual: float, predicted: float) -> tuple[bool, float]:
    """Accept a step that decreases the cost, and choose the next damping by the gain ratio.

    A low gain ratio is overshoot across a narrow valley, accepted or not: the damping is raised.
    """
    if actual > MIN_GAIN_RATIO * predicted:
        return actual > 0, max(damping * 0.1, MIN_DAMPING)
    return actual > 0, max(damping, MIN_RAISED_DAMPING) * 10


def robust_sigma(state: State, counted: Mask) -> float:
    """Standard deviation of one coordinate of the residuals, px, from their median length.

    Over the points that count (v, n): lengths of good residuals have Rayleigh's distribution. Infinite
    without points.
    """
    square = state.square[counted] if not counted.all() else state.square.reshape(-1)
    if not square.size:
        return np.inf
    used = square.size * 2
    unknowns = len(state.rows) - 1 - POSE_SIZE + POSE_SIZE * len(state.square)
    middle = square.size // 2
    median2 = float(np.partition(square, middle)[middle])
    return math.sqrt(median2 * used / max(used - unknowns, 0.1 * used)) / RAYLEIGH_MEDIAN
