"""Fit of intrinsics, poses and the board's shape together.

Least squares from the optimum with the board as drawn. The variance of the shape is learnt where it begins
and where it ends. Motion of the hand during the readout is not estimated: on real sets the misfit of the lens
would be taken for it. It counts in the covariance.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..arrays import Array, IntArray, Mask, block_diagonal, dot, whitening
from . import (
    levenberg_marquardt,
    normal_equations,
    outliers,
    robust_covariance,
    systematic_effects,
)
from .board_shape import BoardShape
from .levenberg_marquardt import LeastSquares, Options, Problem, State
from .mixed_model import EXPECTED_MOTION, SHAPE_SIZE, MixedModel, Variances, trusted_motion
from .normal_equations import POSE_SIZE, Poses
from .observations import Observations
from .robust_covariance import Evidence, Result

MIN_SHAPE_DECREASE = 15.0
"""Decrease of the cost, in squares of the noise, by a shape that is believed: with five numbers chance brings
more to one flat board in a hundred."""
TYPICAL_NOISE_WIDTHS = 0.25 / 1280
"""Noise of a corner's coordinate / image width that is usual."""
NO_METRIC: Array = np.zeros((0, 0))
"""Metric of a linearization that is not asked for error bars."""
PRIOR_NOISE_WIDTHS = 1e-5
"""Noise / image width below which the prior of the intrinsics gains no more weight."""
IN_SHAPE = Options(tolerance=1e-8, one_step=True)
"""A hundredth of a standard deviation is 1e-4 squares of the noise, of thousands."""


@dataclass(frozen=True, eq=False)
class ShapedProblem(LeastSquares):
    """Problem of a camera whose board has a shape: k is that shape (SHAPE_SIZE,), then the intrinsics (p,).

    Attributes
    ----------
    obs
        Observations of the board as drawn.
    drawn
        Problem of that board.
    frame
        Shape of which the parameters are estimated.
    variances
        Of the noise, which weighs the priors, and of the shape.
    """

    obs: Observations
    drawn: Problem
    frame: BoardShape
    variances: Variances

    @property
    def width(self) -> int:
        """Width of the image, px."""
        return self.drawn.width

    @cached_property
    def heights(self) -> Array:
        """Derivatives (3, v, n) of the points' heights by the shape, board units."""
        x, y = self.places
        half = self.frame.half
        return np.stack([x * x, x * y, y * y]) * (2 / half)

    @cached_property
    def places(self) -> Array:
        """Points (2, v, n) from the middle of the board, board units."""
        out: Array = self.obs.points[:, :2].transpose(1, 0, 2) - np.array(self.frame.center)[:, None, None]
        return out

    def points(self, shape: Array) -> Array:
        """Points (v, 3, n) of the board in a shape (SHAPE_SIZE,)."""
        out = self.obs.points.copy()
        x, y = self.places
        out[:, 2] += np.tensordot(shape[:3], self.heights, 1)
        out[:, 0] += shape[3] * x + shape[4] * y
        out[:, 1] -= shape[3] * y
        return out

    def is_feasible(self, k: Array) -> bool:
        """Whether the model has a picture at all with k."""
        return self.drawn.is_feasible(k[SHAPE_SIZE:])

    def noise(self, state: State, counted: Mask) -> float:
        """Noise of a coordinate, px, as it was learnt."""
        del state, counted
        return max(float(np.sqrt(self.variances.noise2)), PRIOR_NOISE_WIDTHS * self.width)

    def believing(self, state: State) -> State:
        """Return a state with the prior of these variances."""
        certain, jacobian = 1 / self.variances.shape_deviations(), state.prior_jacobian.copy()
        jacobian[:SHAPE_SIZE, :SHAPE_SIZE] = np.diag(certain)
        r = np.append(state.k[:SHAPE_SIZE] * certain, state.prior_residuals[SHAPE_SIZE:])
        return replace(state, prior_residuals=r, prior_jacobian=jacobian)

    def start(self, state: State) -> State:
        """Linearize about a state of the board as drawn."""
        return self._with_shape(np.append(np.zeros(SHAPE_SIZE), state.k), state.poses, state.rows)

    def at(self, k: Array, poses: Poses) -> State:
        """Linearize at a shape and intrinsics k, and poses."""
        drawn, points = self.drawn, self.points(k[:SHAPE_SIZE])
        rows, _ = levenberg_marquardt.residual_rows(
            drawn.model, k[SHAPE_SIZE:], poses, replace(self.obs, points=points), SHAPE_SIZE
        )
        return self._with_shape(k, poses, drawn.free_rows(rows, SHAPE_SIZE))

    def free(self, da: Array) -> Array:
        """Change of the shape and all intrinsics by a step of the shape and the free ones."""
        return np.append(da[:SHAPE_SIZE], self.drawn.free(da[SHAPE_SIZE:]))

    def residuals(self, k: Array, poses: Poses) -> Array:
        """Compute the residuals (2, v, n) at a shape and intrinsics k, and poses, px."""
        points = self.points(k[:SHAPE_SIZE])
        q = normal_equations.project(self.drawn.model, k[SHAPE_SIZE:], poses, points)
        r: Array = (q - self.obs.pixels).transpose(1, 0, 2)
        return r if self.obs.scale is None else r * self.obs.scale

    def camera_state(self, state: State) -> State:
        """Return the state of the camera alone, of the board in its shape."""
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

    def _with_shape(self, k: Array, poses: Poses, rows: Array) -> State:
        """State of rows of a camera, (a + 7, 2, v, n), or with SHAPE_SIZE more before them, to be filled."""
        r, j = self.drawn.prior(k[SHAPE_SIZE:])
        size = j.shape[1]
        if len(rows) == size + POSE_SIZE + 1:
            rows = np.concatenate([np.empty((SHAPE_SIZE, *rows.shape[1:])), rows])
        x, y = self.places
        by_x, by_y, by_z = np.einsum("vij,iavn->javn", poses.r, rows[-4:-1])
        for out, height in zip(rows, self.heights, strict=False):
            np.multiply(by_z, height, out=out)
        np.multiply(by_x, x, out=rows[3])
        rows[3] -= by_y * y
        np.multiply(by_x, y, out=rows[4])
        certain = 1 / self.variances.shape_deviations()
        return State(
            k,
            poses,
            rows,
            rows[-1, 0] ** 2 + rows[-1, 1] ** 2,
            np.append(k[:SHAPE_SIZE] * certain, r),
            block_diagonal(np.diag(certain), j),
        )


@dataclass(frozen=True, eq=False)
class Linearization:
    """Mixed model of the views about a state.

    Attributes
    ----------
    state
        State of a `ShapedProblem`.
    effects
        (MOTION_SIZE, 2, v, n) displacements by motion, px.
    evidence, model
        Of the points that count.
    """

    state: State
    effects: Array
    evidence: Evidence
    model: MixedModel


@dataclass(frozen=True, eq=False)
class MixedFit:
    """Fit of a board's shape with the rest.

    Attributes
    ----------
    problem
        Problem with the shape, at variances to begin with.
    labels
        (v,) clusters of views in nearly the same pose.
    """

    problem: ShapedProblem
    labels: IntArray

    @classmethod
    def of(cls, drawn: Problem, labels: IntArray, noise2: float) -> "MixedFit":
        """Return the fit of a problem with the board as drawn, of noise of variance `noise2`, px^2."""
        obs = drawn.obs
        return cls(ShapedProblem(obs, drawn, BoardShape.of(obs), Variances(noise2)), labels)

    def linearize(self, state: State, good: Mask, metric: Array | None = NO_METRIC) -> Linearization:
        """Gather the mixed model of the good points (v, n) about a state.

        `metric` (p, p) is that of the projection error (`robust_covariance.Evidence`); None: at the corners.
        """
        drawn = self.problem.drawn
        row = systematic_effects.row_position(drawn.obs.pixels[:, 1], drawn.img_size[1])
        effects = systematic_effects.motion(state.rows[-POSE_SIZE - 1 : -1], drawn.obs.points, row)
        used = None if good.all() else good
        evidence = Evidence.of(state.rows, effects, state.poses, self.labels, metric, used)
        if metric is None:  # the shape is no part of the camera
            known = np.zeros_like(evidence.metric)
            known[SHAPE_SIZE:, SHAPE_SIZE:] = evidence.metric[SHAPE_SIZE:, SHAPE_SIZE:]
            evidence = replace(evidence, metric=known)
        r, j = state.prior_residuals[SHAPE_SIZE:], state.prior_jacobian[SHAPE_SIZE:, SHAPE_SIZE:]
        noise2 = self.problem.variances.noise2
        # Below any detector's noise the prior keeps some weight: corners without any would leave it none.
        weight = max((PRIOR_NOISE_WIDTHS * drawn.width) ** 2 / noise2, 1.0)
        mixed = MixedModel(
            evidence.gram,
            2 * int(good.sum()) - POSE_SIZE * int(good.any(axis=1).sum()),
            (weight * j.T @ j, weight * j.T @ r),
            state.k[:SHAPE_SIZE],
            (levenberg_marquardt.ROUNDOFF * drawn.width) ** 2,
            # Less motion is expected where the corners show less noise than most.
            EXPECTED_MOTION * min(noise2 / (TYPICAL_NOISE_WIDTHS * drawn.width) ** 2, 1.0),
        )
        return Linearization(state, effects, evidence, mixed)

    def at_variances(self, model: MixedModel, v: Variances) -> "MixedFit":
        """Return the fit at learnt variances, without motion: what moves counts as noise."""
        noise2 = model.solve(replace(v, motion=0.0)).variances.noise2
        return replace(self, problem=replace(self.problem, variances=replace(v, noise2=noise2)))

    def solve(self, state: State, good: Mask) -> State:
        """Solve for the optimum of the good points (v, n)."""
        return self.problem.solve(self.problem.believing(state), outliers.unit_weights(good), IN_SHAPE)

    def spread(self, state: State, good: Mask, sigma: float, mask: Mask) -> Result:
        """Covariance of what the views share, with the motion that the residuals show.

        Parameters
        ----------
        state, good
            The optimum, and the points (v, n) that took part.
        sigma
            px, noise of a coordinate there, motion and all.
        mask
            (v, n) points that may show motion: those that the fit cut, but motion explains, were moved
            farthest.
        """
        noise2 = sigma**2
        at = self.linearize(state, good, None)
        v = at.model.learn(replace(self.problem.variances, noise2=noise2))
        if not np.array_equal(mask, good):
            u = at.model.moved(at.model.solve(v).u)
            left = state.rows[-1] + np.einsum("vm,mavn->avn", u[self.labels], at.effects)
            seen = good | (mask & (np.sum(left**2, axis=0) < (outliers.OUTLIER_SIGMAS * sigma) ** 2))
            if not np.array_equal(seen, good):
                v = self.linearize(state, seen).model.learn(v)
        v = replace(v, motion=trusted_motion(v, at.model.noise2))
        return _covariance(at, v, noise2)


def _covariance(at: Linearization, v: Variances, noise2: float) -> Result:
    """Covariance of shape and intrinsics by the formula of `robust_covariance`, without its effect of bend.

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
