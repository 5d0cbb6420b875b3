"""Fit of intrinsics, poses and the board's shape together.

Least squares from the optimum with the board as drawn. The variance of the shape is learnt where it begins
and where it ends. Motion of the hand during the readout is not estimated: on real sets the misfit of the lens
would be taken for it. It counts in the covariance.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..arrays import Array, IntArray, Mask, block_diagonal, dot, whitening
from . import levenberg_marquardt, outliers, robust_covariance, systematic_effects
from .board_shape import BoardShape
from .levenberg_marquardt import LeastSquares, Options, Problem, State
from .mixed_model import (
    EXPECTED_MOTION,
    EXPECTED_STRETCH,
    MAX_STRETCH_DEVIATION,
    SHAPE_SIZE,
    MixedModel,
    Variances,
    trusted_motion,
)
from .normal_equations import POSE_SIZE, Poses
from .observations import Observations
from .robust_covariance import Evidence, Result
from .systematic_effects import BEND_SIZE

MIN_SHAPE_DECREASE = 15.0
"""Decrease of the cost, in squares of the noise, by a shape that is believed. With five numbers chance
brings more to one flat board in a hundred."""
TYPICAL_NOISE_WIDTHS = 0.25 / 1280
"""Usual noise of a corner's coordinate / image width."""
PRIOR_NOISE_WIDTHS = 1e-5
"""Noise / image width below which the prior of the intrinsics gains no more weight."""
IN_SHAPE = Options(tolerance=1e-8, one_step=True)
"""A hundredth of a standard deviation is 1e-4 squares of the noise, of thousands."""


@dataclass(frozen=True, eq=False)
class ShapedProblem(LeastSquares):
    """Problem of a camera or a rig whose board has a shape: k is that shape (SHAPE_SIZE,), then theirs (p,).

    `obs` and `drawn` are of the board as drawn, `frame` is the shape of which the parameters are estimated,
    with derivatives `displacements` (SHAPE_SIZE, v, 3, n) of the points.
    """

    obs: Observations
    drawn: LeastSquares
    frame: BoardShape
    displacements: Array
    variances: Variances
    straight_iterations: ClassVar[int] = Problem.straight_iterations

    @classmethod
    def of(cls, drawn: LeastSquares, variances: Variances) -> "ShapedProblem":
        """Problem whose board gets a shape."""
        frame, points = BoardShape.of(drawn.obs), drawn.obs.points
        moved = frame.displacements(points.transpose(1, 0, 2)).transpose(0, 2, 1, 3)
        return cls(drawn.obs, drawn, frame, np.ascontiguousarray(moved), variances)

    @property
    def width(self) -> int:
        """Width of the image, px."""
        return self.drawn.width

    def reshaped(self, shape: Array, obs: Observations) -> Observations:
        """Observations of the board in a shape (SHAPE_SIZE,)."""
        moved = (shape @ self.displacements.reshape(SHAPE_SIZE, -1)).reshape(obs.points.shape)
        moved += obs.points
        return Observations(moved, obs.pixels, obs.mask, obs.scale)

    def is_feasible(self, k: Array) -> bool:
        """True if there is an image."""
        return self.drawn.is_feasible(k[SHAPE_SIZE:])

    def noise(self, state: State, counted: Mask) -> float:
        """Noise of a coordinate, px, as it was learnt."""
        del state, counted
        return max(float(np.sqrt(self.variances.noise2)), PRIOR_NOISE_WIDTHS * self.width)

    def at(self, k: Array, poses: Poses) -> State:
        """Linearize at k and poses."""
        rows, square = self.rows_of(k, poses, self.obs)
        by_point = np.empty_like(rows[:3])
        by_camera_point = rows[-4:-1].transpose(1, 2, 0, 3)
        np.matmul(poses.r.transpose(0, 2, 1), by_camera_point, out=by_point.transpose(1, 2, 0, 3))
        by_x, by_y, by_z = by_point
        for i in range(BEND_SIZE):
            np.multiply(by_z, self.displacements[i, :, 2], out=rows[i])
        np.multiply(by_x, self.displacements[3, :, 0], out=rows[3])
        rows[3] += by_y * self.displacements[3, :, 1]
        np.multiply(by_x, self.displacements[4, :, 0], out=rows[4])
        return State(k, poses, rows, square, *self.prior(k))

    @property
    def row_positions(self) -> Array:
        """Rows (v, n) of the points."""
        return self.drawn.row_positions

    def prior(self, k: Array) -> tuple[Array, Array]:
        """Residuals and Jacobian of the priors of shape and intrinsics."""
        r, j = self.drawn.prior(k[SHAPE_SIZE:])
        certain = 1 / self.variances.shape_deviations()
        return np.append(k[:SHAPE_SIZE] * certain, r), block_diagonal(np.diag(certain), j)

    def rows_of(self, k: Array, poses: Poses, obs: Observations, before: int = 0) -> tuple[Array, Array]:
        """Rows of a `State`, those of the shape empty."""
        return self.drawn.rows_of(
            k[SHAPE_SIZE:], poses, self.reshaped(k[:SHAPE_SIZE], obs), before + SHAPE_SIZE
        )

    def residuals_of(self, k: Array, poses: Poses, obs: Observations) -> Array:
        """Residuals (2, v, n), px."""
        return self.drawn.residuals_of(k[SHAPE_SIZE:], poses, self.reshaped(k[:SHAPE_SIZE], obs))

    def retract(self, k: Array, poses: Poses, da: Array, dp: Array) -> tuple[Array, Poses]:
        """Change k and poses by steps (SHAPE_SIZE + a,) and (v, 6)."""
        camera, moved = self.drawn.retract(k[SHAPE_SIZE:], poses, da[SHAPE_SIZE:], dp)
        return np.append(k[:SHAPE_SIZE] + da[:SHAPE_SIZE], camera), moved

    def of_camera(self, state: State) -> State:
        """State without the shape."""
        return replace(
            state,
            k=state.k[SHAPE_SIZE:],
            rows=state.rows[SHAPE_SIZE:],
            prior_residuals=state.prior_residuals[SHAPE_SIZE:],
            prior_jacobian=state.prior_jacobian[SHAPE_SIZE:, SHAPE_SIZE:],
        )

    def shape(self, state: State) -> BoardShape:
        """Shape of the board at a state."""
        return replace(self.frame, parameters=tuple(state.k[:SHAPE_SIZE].tolist()))


@dataclass(frozen=True, eq=False)
class MixedFit:
    """Fit of a board's shape with the rest, for clusters (v,) of views in nearly the same pose.

    Variances are learnt starting from `begun`.
    """

    problem: ShapedProblem
    labels: IntArray
    begun: Variances
    max_stretch: float = MAX_STRETCH_DEVIATION

    @classmethod
    def begin(
        cls, drawn: LeastSquares, state: State, good: Mask, labels: IntArray, noise2: float
    ) -> "tuple[MixedFit, State] | None":
        """Begin at the optimum for the good points (v, n) with the board as drawn.

        `noise2` is that of the corners, px^2.

        None if a shape explains no more than chance and motion do.
        """
        if noise2 < (PRIOR_NOISE_WIDTHS * drawn.width) ** 2:  # a bend leaves more
            return None
        v = Variances(noise2)
        fit = cls(ShapedProblem.of(drawn, v), labels, v)
        begun = fit.problem.at(np.append(np.zeros(SHAPE_SIZE), state.k), state.poses)
        model = fit.linearize(begun, good)
        fit, v = fit._learn(model)
        if not model.shape_gain(v) > MIN_SHAPE_DECREASE:
            return None
        return fit._at_variances(model, v), begun

    def linearize(self, state: State, good: Mask) -> MixedModel:
        """Mixed model of the good points (v, n) about a state."""
        gram = robust_covariance.cluster_grams(state.rows, self._motion(state), self.labels, good)
        return self._model(state, good, gram)

    def _motion(self, state: State) -> Array:
        """Displacements (MOTION_SIZE, 2, v, n) by motion, px."""
        drawn = self.problem.drawn
        by_pose = state.rows[-POSE_SIZE - 1 : -1]
        return systematic_effects.motion(by_pose, drawn.obs.points, drawn.row_positions)

    def _model(self, state: State, good: Mask, gram: Array) -> MixedModel:
        drawn = self.problem.drawn
        r, j = state.prior_residuals[SHAPE_SIZE:], state.prior_jacobian[SHAPE_SIZE:, SHAPE_SIZE:]
        noise2 = self.problem.variances.noise2
        # Below any detector's noise the prior keeps some weight: corners without any would leave it none.
        weight = max((PRIOR_NOISE_WIDTHS * drawn.width) ** 2 / noise2, 1.0)
        return MixedModel(
            gram,
            2 * int(good.sum()) - POSE_SIZE * int(good.any(axis=1).sum()),
            (weight * j.T @ j, weight * j.T @ r),
            state.k[:SHAPE_SIZE],
            (levenberg_marquardt.ROUNDOFF * drawn.width) ** 2,
            # Less motion is expected where the corners show less noise than most.
            EXPECTED_MOTION * min(noise2 / (TYPICAL_NOISE_WIDTHS * drawn.width) ** 2, 1.0),
            self.max_stretch,
        )

    def learnt(self, model: MixedModel) -> "MixedFit":
        """Fit at the variances that a linearization teaches."""
        fit, v = self._learn(model)
        return fit._at_variances(model, v)

    def _learn(self, model: MixedModel) -> "tuple[MixedFit, Variances]":
        """Learn the variances. A stretch that no printer causes has next to none."""
        learnt = model.learn(self.begun)
        expected = tuple((model.shape + learnt.one[:SHAPE_SIZE]).tolist())
        if replace(self.problem.frame, parameters=expected).is_plausible:
            return self, learnt.variances
        model.max_stretch = EXPECTED_STRETCH
        learnt = model.learn(replace(learnt.variances, stretch=EXPECTED_STRETCH))
        return replace(self, max_stretch=EXPECTED_STRETCH), learnt.variances

    def _at_variances(self, model: MixedModel, v: Variances) -> "MixedFit":
        """Fit at learnt variances, without motion: it counts as noise."""
        noise2 = model.solve(replace(v, motion=0.0)).variances.noise2
        return replace(self, problem=replace(self.problem, variances=replace(v, noise2=noise2)), begun=v)

    def solve(self, state: State, good: Mask, options: Options = IN_SHAPE) -> State:
        """Solve for the optimum of the good points (v, n)."""
        r, jacobian = self.problem.prior(state.k)
        begun = replace(state, prior_residuals=r, prior_jacobian=jacobian)
        return self.problem.solve(begun, good, options)

    def spread(
        self, state: State, good: Mask, sigma: float, mask: Mask, metric: Array | None = None
    ) -> Result:
        """Covariance of k at the optimum of the good points (v, n), with the motion that the residuals show.

        `sigma` is the noise of a coordinate, px, with motion. Points in the `mask` (v, n) that motion
        explains count. A `metric` (p, p), without the shape, replaces the one at the corners.
        """
        noise2, effects = sigma**2, self._motion(state)
        if metric is not None:
            metric = block_diagonal(np.zeros((SHAPE_SIZE, SHAPE_SIZE)), metric)
        evidence = Evidence.of(state.rows, effects, state.poses, self.labels, metric, good)
        model = self._model(state, good, evidence.gram)
        learnt = model.learn(self.begun)
        if not np.array_equal(mask, good):
            motion = model.motion(learnt)[self.labels]
            left = state.rows[-1] + np.einsum("vm,mavn->avn", motion, effects)
            seen = good | (mask & (np.sum(left**2, axis=0) < (outliers.OUTLIER_SIGMAS * sigma) ** 2))
            if not np.array_equal(seen, good):
                gram = robust_covariance.with_more_points(
                    evidence.gram, state.rows, effects, self.labels, good, seen
                )
                learnt = self._model(state, seen, gram).learn(learnt.variances)
        v = learnt.variances
        v = replace(v, motion=trusted_motion(v, model.noise2))
        of_camera = np.zeros_like(evidence.metric)  # the shape is not part of the camera
        of_camera[SHAPE_SIZE:, SHAPE_SIZE:] = evidence.metric[SHAPE_SIZE:, SHAPE_SIZE:]
        return _covariance(model, of_camera, v, noise2)


def _covariance(model: MixedModel, metric: Array, v: Variances, noise2: float) -> Result:
    """Covariance by the formula of `robust_covariance` without bend; `noise2` (px^2) of the residuals."""
    size = model.size
    information = model.information(v)
    basis = whitening(information)
    w = basis.T @ metric @ basis
    b = basis.T @ model.gram[:, :size, :size] @ basis
    h = model.gram[:, :size, -1] @ basis / np.sqrt(v.noise2)
    pull = basis.T @ model.rows[:, :size]
    working = b + v.motion / v.noise2 * pull @ pull.transpose(0, 2, 1)
    inflation = robust_covariance.scatter_inflation(w, b, working, h)
    shape = np.eye(size) - b.sum(axis=0) + inflation * working.sum(axis=0)
    covariance: Array = v.noise2 * basis @ shape @ basis.T
    white = noise2 * float(np.trace(w))
    seen = v.noise2 * dot(w, shape) / white if white > 0 else 1.0
    return Result((covariance + covariance.T) / 2, information / noise2, max(seen, 1.0))
