"""Fit of intrinsics, poses and the board's shape together.

Gauss-Newton steps from the optimum of least squares, with the variance of the shape learnt at each of them.
Motion of the hand during the readout is not estimated: on real sets the misfit of the lens would be taken for
it. It counts in the covariance.
"""

from dataclasses import dataclass, replace

import numpy as np

from .. import deadline
from ..arrays import Array, IntArray, Mask, block_diagonal, dot, whitening
from . import levenberg_marquardt, robust_covariance, systematic_effects
from .board_shape import BoardShape
from .levenberg_marquardt import Problem, State
from .mixed_model import EXPECTED_MOTION, SHAPE_SIZE, MixedModel, Solution, Variances, trusted_motion
from .normal_equations import POSE_SIZE, Poses
from .outliers import OUTLIER_SIGMAS
from .robust_covariance import Evidence, Result
from .systematic_effects import BEND_SIZE

MAX_GAUSS_NEWTON_STEPS = 12
MIN_STEP_DECREASE = 1e-4
"""Decrease of the cost, in squares of the noise, that a last step would bring."""
MIN_SHAPE_DECREASE = 15.0
"""Decrease of the cost, in squares of the noise, by a shape that is believed: with five numbers chance brings
more to one flat board in a hundred."""
TYPICAL_NOISE_WIDTHS = 0.25 / 1280
"""Noise of a corner's coordinate / image width that is usual."""
TRIED_SHARES = (1.0, 0.5, 0.25, 0.1)
"""Shares of a step that are tried."""
NO_METRIC: Array = np.zeros((0, 0))
"""Metric of a linearization that is not asked for error bars."""
PRIOR_NOISE_WIDTHS = 1e-5
"""Noise / image width below which the prior of the intrinsics gains no more weight."""


@dataclass(frozen=True, eq=False)
class Linearization:
    """Mixed model of the views about a state and a shape.

    Attributes
    ----------
    state, shape
        Where, with the board in its shape.
    effects
        (MOTION_SIZE, 2, v, n) displacements by motion, px.
    evidence, model
        Of the points that count.
    prior_cost
        Squares of the prior's residuals.
    """

    state: State
    shape: BoardShape
    effects: Array
    evidence: Evidence
    model: MixedModel
    prior_cost: float

    def cost(self, v: Variances) -> float:
        """Cost at the variances `v`, in squares of the noise."""
        total = float(self.model.gram[:, -1, -1].sum()) / v.noise2 + self.prior_cost
        total += float(v.shape_information() @ np.square(self.shape.parameters))
        return total if np.isfinite(total) else np.inf


@dataclass(frozen=True, eq=False)
class MixedFit:
    """Views whose points (v, n) `good` take part.

    Attributes
    ----------
    problem
        Model and observations, with the board as drawn.
    good
        (v, n) points that take part.
    labels
        (v,) clusters of views in nearly the same pose.
    """

    problem: Problem
    good: Mask
    labels: IntArray

    def at(
        self,
        k: Array,
        poses: Poses,
        shape: BoardShape,
        noise2: float,
        metric: Array | None = NO_METRIC,
    ) -> Linearization:
        """Linearize about shared unknowns (p,), poses and a shape.

        `metric` (p, p) is that of the projection error (`robust_covariance.Evidence`); None: at the corners.
        """
        problem = self.problem.reshaped(shape)
        state = problem.at(k, poses)
        rows, points = state.rows, self.problem.obs.points
        size = len(rows) - POSE_SIZE - 1
        row = systematic_effects.row_position(self.problem.obs.pixels[:, 1], self.problem.img_size[1])
        effects = systematic_effects.displacements(rows[size:-1], poses, points, row)[BEND_SIZE:]
        by_shape = shape.columns(rows[size + 3 : -1], poses.r, points)
        rows = np.concatenate([rows[:size], by_shape, rows[size:]])
        evidence = Evidence.of(
            rows, effects, poses, self.labels, metric, None if self.good.all() else self.good
        )
        if metric is not NO_METRIC:  # the shape is no part of the camera
            known = evidence.metric[:size, :size]
            nothing = np.zeros((SHAPE_SIZE, SHAPE_SIZE))
            evidence = replace(evidence, metric=block_diagonal(known, nothing))
        r, j = state.prior_residuals, state.prior_jacobian
        # Below any detector's noise the prior keeps some weight: corners without any would leave it none.
        weight = max((PRIOR_NOISE_WIDTHS * self.problem.width) ** 2 / noise2, 1.0)
        mixed = MixedModel(
            evidence.gram,
            2 * int(self.good.sum()) - POSE_SIZE * int(self.good.any(axis=1).sum()),
            (weight * j.T @ j, weight * j.T @ r),
            np.array(shape.parameters),
            (levenberg_marquardt.ROUNDOFF * self.problem.width) ** 2,
            self._expected_motion(noise2),
        )
        return Linearization(state, shape, effects, evidence, mixed, weight * float(r @ r))

    def _expected_motion(self, noise2: float) -> float:
        """Variance of motion to expect: less where the corners show less noise than most."""
        return EXPECTED_MOTION * min(noise2 / (TYPICAL_NOISE_WIDTHS * self.problem.width) ** 2, 1.0)

    def tells_shape(self, start: State, noise2: float) -> bool:
        """True if a shape of the board explains more than chance does, and more than motion."""
        at = self.at(start.k, start.poses, BoardShape.of(self.problem.obs), noise2)
        v, _ = at.model.learn(Variances(noise2))
        return at.model.shape_gain(v) > MIN_SHAPE_DECREASE

    def solve(self, start: State, shape: BoardShape, v: Variances) -> tuple[Linearization, Variances] | None:
        """Iterate from a state, a shape and variances near it to the optimum; None where there is none."""
        at = self.at(start.k, start.poses, shape, v.noise2)
        for _ in range(MAX_GAUSS_NEWTON_STEPS):
            deadline.check()
            v, _ = at.model.learn(v)
            # Least squares, with the shape as variable as the views tell when motion is allowed for.
            plain = replace(v, motion=0.0, noise2=at.model.noise2)
            found = at.model.solve(plain)
            if not np.isfinite(found.x).all():
                return None
            if self._decrease(at, found, plain) < MIN_STEP_DECREASE:
                break
            after = self._step(at, found, plain)
            if after is None:
                break
            at = after
        return at, v

    def spread(
        self,
        at: Linearization,
        noise2: float,
        metric: Array | None = None,
        *,
        mask: Mask | None = None,
    ) -> Result:
        """Covariance of what the views share there, with the motion that the residuals show.

        Parameters
        ----------
        metric
            As for `at`.
        mask
            (v, n) points that may show it: those that the fit cut, but motion explains, were moved farthest.
        """
        at = self.at(at.state.k, at.state.poses, at.shape, noise2, metric)
        v, found = at.model.learn(Variances(noise2))
        if mask is not None and not np.array_equal(mask, self.good):
            left = at.state.rows[-1] + np.einsum("vm,mavn->avn", found.u[self.labels], at.effects)
            seen = self.good | (mask & (np.sum(left**2, axis=0) < OUTLIER_SIGMAS**2 * noise2))
            more = replace(self, good=seen).at(at.state.k, at.state.poses, at.shape, noise2)
            v, _ = more.model.learn(v)
        v = replace(v, motion=trusted_motion(v, at.model.noise2))
        return _covariance(at, v, noise2)

    def _decrease(self, at: Linearization, found: Solution, v: Variances) -> float:
        """Decrease of the cost that a step predicts, in squares of the noise."""
        slope = at.model.total[:-1, -1] / v.noise2 + at.model.belief(v)[1]
        return -float(found.x @ slope)

    def _step(self, at: Linearization, found: Solution, v: Variances) -> Linearization | None:
        """Linearize after a step, or a share of it, that lowers the cost; None where none does."""
        k, poses, x = at.state.k, at.state.poses, found.x
        size, before = len(x) - SHAPE_SIZE, at.cost(v)
        turn = -(at.evidence.solved[:, :, : len(x)] @ x + at.evidence.solved[:, :, -1])
        for share in TRIED_SHARES:
            moved = k + share * self.problem.free(x[:size])
            if not self.problem.is_feasible(moved):
                continue
            shape = at.shape.shifted(share * x[size:])
            after = self.at(moved, poses.retract(share * turn), shape, v.noise2)
            if after.cost(v) < before:
                return after
        return None


def _covariance(at: Linearization, v: Variances, noise2: float) -> Result:
    """Covariance of intrinsics and shape by the formula of `robust_covariance`, without its effect of bend.

    `noise2` (px^2) is the variance of the residuals, motion and all.
    """
    size, model = at.model.size, at.model
    information = model.total[:size, :size] + v.noise2 * model.belief(v)[0]
    basis = whitening(information)
    w = basis.T @ at.evidence.metric @ basis
    b = basis.T @ model.gram[:, :size, :size] @ basis
    h = model.gram[:, :size, size] @ basis / np.sqrt(v.noise2)
    pull = basis.T @ model.rows[:, :size]
    working = b + v.motion / v.noise2 * pull @ pull.transpose(0, 2, 1)
    inflation = robust_covariance.scatter_inflation(w, b, working, h)
    shape = np.eye(size) - b.sum(axis=0) + inflation * working.sum(axis=0)
    covariance: Array = v.noise2 * basis @ shape @ basis.T
    white = noise2 * float(np.trace(w))
    seen = v.noise2 * dot(w, shape) / white if white > 0 else 1.0
    return Result((covariance + covariance.T) / 2, information / noise2, max(seen, 1.0))
