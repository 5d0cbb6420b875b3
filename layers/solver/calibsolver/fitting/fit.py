"""Fit of a camera model to views: a calibration, or the reason why there is none."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .. import models
from ..arrays import Array, Mask, frozen
from ..camera import Camera
from ..errors import CalibrationError, undetermined
from ..view import View
from . import (
    constraint,
    domain,
    focal_profile,
    initial_guess,
    levenberg_marquardt,
    normal_equations,
    outliers,
    plausibility,
    resection,
    robust_covariance,
    systematic_effects,
    validation,
)
from .calibration import Calibration
from .constraint import Fix
from .levenberg_marquardt import Options, Problem, State
from .mixed_fit import MixedFit
from .mixed_model import SHAPE_SIZE, marginal_information
from .multistart import MultiStart, constrained, refit_without_gross_outliers
from .normal_equations import POSE_SIZE, Poses
from .observations import Order
from .validation import check, degenerate_views, pack

MAX_TAIL_RMS_RATIO = 1.1
"""Rms over all but gross outliers / rms of the inliers, up to which all of them count."""
MAX_RIM_RMS_RATIO = 4.0
"""The same where outliers concentrate at the rim: the model is a little too simple."""
MAX_REJECTIONS = 6
MIN_SHAPE_VIEWS = 3
"""Views that distinguish the shape of the board from the lens."""
MAX_MASKS = 2
REJECTION = Options(tolerance=1e-5, one_step=True)
FREE = Options(with_prior=False, iterations=400, tolerance=1e-15)
"""Least squares without the prior may wind through long valleys."""


@undetermined()
def fit(
    views: Sequence[View],
    img_size: tuple[int, int],
    model: str = "rectilinear",
    robust: bool = True,
    *,
    start: Camera | None = None,
    fix: Fix = (),
    board_shape: bool = True,
) -> Calibration:
    """Fit a camera model to views of a planar board.

    Parameters
    ----------
    views
        At least one; each with at least six points, and one or more with points that do not lie on a line.
    img_size
        Width and height, px.
    model
        One of `models.NAMES`.
    robust
        Set aside views whose points lie on a line, cut points beyond 4 sigma, and fit the rest by least
        squares with the model's weak prior. False: plain least squares over all points; with the prior only
        where the points leave something open.
    start
        A camera that may be near. The result depends on it only if the views allow two optima
        (`focal_profile`), and by what `fix` keeps from it.
    fix
        What is not estimated (`constraint`): names, or a mapping of names to values; variance 0.
    board_shape
        Estimate bend and stretch of the board, if at least MIN_SHAPE_VIEWS views take part and a shape
        explains them better than chance and motion do. The board is as drawn in plain least squares and if a
        view is `flat`. False: as drawn, in less time.

    Raises
    ------
    CalibrationError
        ``no_views``, ``too_few_points``, ``degenerate``, ``not_planar``, ``out_of_range``,
        ``outside_image``, ``mirrored``, ``unknown_model``, ``unknown_parameter``, ``no_value``,
        ``no_fit``, ``not_converged`` or ``not_believable``. An implausible fit is never returned.
    """
    camera_model = models.get(model)
    views = list(views or ())
    board_shape = board_shape and not any(view.flat for view in views)
    given = pack(views, img_size)
    basis, origin = constraint.of(camera_model, img_size, fix, start)
    degenerate = degenerate_views(given)
    if degenerate.any():
        if degenerate.all() or not robust:
            check(views, img_size)  # raises: too little is left, or nothing may be left out
        kept = [views[i] for i in np.flatnonzero(~degenerate)]
        found = fit(kept, img_size, model, start=start, fix=fix, board_shape=board_shape)
        return found.with_degenerate_views(views, degenerate)
    mirrored = validation.mirrored_views(given)
    if mirrored.any() and not robust:
        raise CalibrationError("mirrored", f"view {int(np.argmax(mirrored))} shows the board mirrored")
    # Canonical order of the views, so that rounding and results are bit-identical.
    obs, order = given.sort_canonically()
    # Far from the solution numbers may overflow; every step is tested before it is taken.
    with np.errstate(all="ignore"):
        problem = Problem(camera_model, obs, img_size, basis, origin)
        found = _Fit(problem, order, mirrored[order.views], robust, start, board_shape).run()
    return replace(found, fixed=constraint.names(fix))


@undetermined()
def refine(views: Sequence[View], near: Camera, poses: Array) -> Calibration:
    """Fit robustly, only from a camera and poses (v, 6) that are nearly right; raises as `fit` does."""
    given = pack(views, near.img_size)
    degenerate = degenerate_views(given)
    if degenerate.any():
        if degenerate.all():
            check(views, near.img_size)  # raises
        kept = np.flatnonzero(~degenerate).tolist()
        found = refine([views[i] for i in kept], near, poses[kept])
        return found.with_degenerate_views(views, degenerate)
    obs, order = given.sort_canonically()
    mirrored = validation.mirrored_views(given)[order.views]
    problem = Problem(models.get(near.model), obs, near.img_size)
    with np.errstate(all="ignore"):
        state = problem.at(near.intrinsics, Poses.of_vectors(poses[order.views]))
        return _Fit(problem, order, mirrored, True, near).run(state)


@dataclass(frozen=True, eq=False)
class Approximation:
    """Camera near the optimum, poses (v, 6) rvec|tvec, NaN of degenerate views, and noise, px per coordinate.

    `cut_views`: reasons why views (by number) are left out, ``degenerate``, ``mirrored`` or ``outlier``.
    """

    camera: Camera
    poses: Array
    noise: float
    cut_views: Mapping[int, str]


def approximate(
    views: Sequence[View],
    img_size: tuple[int, int],
    model: str = "rectilinear",
    *,
    start: Camera | None = None,
) -> Approximation:
    """Fit a camera model to near the optimum; arguments and errors are those of `fit`, robust."""
    packed = pack(views, img_size)
    degenerate, mirrored = degenerate_views(packed), validation.mirrored_views(packed)
    if degenerate.all():
        check(views, img_size)  # raises
    usable = np.flatnonzero(~degenerate)
    obs, order = packed.subset(usable).sort_canonically()
    problem = Problem(models.get(model), obs, img_size)
    mask = obs.mask & ~mirrored[usable][order.views][:, None]
    with np.errstate(all="ignore"):  # far from the solution numbers may overflow; every step is tested
        state = refit_without_gross_outliers(problem, MultiStart(problem, mask, start).run(), mask)
        good = outliers.inlier_mask(state, mask, mask, img_size[0], outliers.GROSS_OUTLIER_SIGMAS)
        plausibility.check_result(problem, state, good, robust=True)
    poses = np.full((len(views), 6), np.nan)
    poses[usable] = order.back(state.poses.vectors())
    left = order.back(np.asarray(good.any(axis=1)))
    reasons = {int(i): "degenerate" for i in np.flatnonzero(degenerate)}
    reasons |= {int(i): "mirrored" if mirrored[i] else "outlier" for i in usable[~left]}
    return Approximation(
        Camera.from_intrinsics(model, state.k, img_size),
        frozen(poses),
        levenberg_marquardt.robust_sigma(state, good),
        reasons,
    )


@dataclass(frozen=True, eq=False)
class _Fit:
    """One fit; `mirrored` (v,) are views that take no part, `known` is a camera that may be near."""

    problem: Problem
    order: Order
    mirrored: Mask
    robust: bool
    known: Camera | None
    board_shape: bool = False

    @cached_property
    def mask(self) -> Mask:
        """Points (v, n) that may take part."""
        measured = self.problem.obs.mask
        return measured & ~self.mirrored[:, None] if self.mirrored.any() else measured

    @cached_property
    def multistart(self) -> MultiStart:
        return MultiStart(self.problem, self.mask, self.known, rejection_follows=self.robust)

    def run(self, near: State | None = None) -> Calibration:
        if not self.robust:
            return self._least_squares(self.multistart.run()).calibration
        state, good = self._settle(near or self.multistart.run())
        found = self._shaped(state, good)
        if found is None:
            if good.any():
                state = self.problem.solve(state, good, Options())
            found = self._result(state, good)
        if near is not None:
            return found.calibration
        covering = domain.covering(self.problem, state, good, found.calibration)
        if covering is not None:
            other = replace(self, problem=covering[0])
            found = other._shaped(covering[1], good) or other._result(covering[1], good)
        covariance = focal_profile.covariance_of_optima(
            found.problem, found.state, found.good, found.calibration
        )
        return replace(found.calibration, covariance=covariance)

    def _shaped(self, state: State, good: Mask) -> "_Found | None":
        """Fit the board's shape with the rest, from an optimum of least squares with the board as drawn.

        What the shape explains is not an outlier. None if there are too few views, or if a shape would
        explain no more than chance or leave an implausible camera.
        """
        if not (self.board_shape and state.converged and good.any(axis=1).sum() >= MIN_SHAPE_VIEWS):
            return None
        problem = self.problem
        labels = robust_covariance.same_pose_labels(
            state.poses, problem.obs, good, problem.focal_widths(state.k)
        )
        begun = MixedFit.begin(problem, state, good, labels, self._sigma(state, good) ** 2)
        if begun is None:
            return None
        mixed, shaped = begun
        for _ in range(MAX_MASKS):
            shaped = mixed.solve(shaped, good, REJECTION)
            taken = outliers.inlier_mask(shaped, self.mask, good, problem.width)
            if outliers.concentrate_at_rim(problem, taken, good):
                taken = taken | good
            if np.array_equal(taken, good) or not taken.any():
                break
            good = taken
        mixed = mixed.learnt(mixed.linearize(shaped, good))
        shaped = mixed.solve(shaped, good)
        if not mixed.problem.shape(shaped).is_plausible:
            return None
        try:
            return self._result(shaped, good, mixed)
        except CalibrationError:
            return None

    def _settle(self, state: State) -> tuple[State, Mask]:
        """State near the optimum, and the points (v, n) that take part.

        Points that hardly spoil the fit are taken back.
        """
        state, inliers, is_fitted = outliers.reject_gross(self.problem, state, self.mask)
        if outliers.concentrate_at_rim(self.problem, inliers, self.mask):
            # The model may fail at the rim: then every point counts, or the failure would go unnoticed.
            all_points = self.problem.solve(state, self.mask, outliers.LEAST_SQUARES)
            if self._is_close(all_points, self.mask, state, inliers, MAX_RIM_RMS_RATIO):
                return all_points, self.mask
        if not inliers.any():  # refused later
            return state, inliers
        with_tails = state
        if not is_fitted:
            with_tails = self.problem.solve(state, inliers, outliers.LEAST_SQUARES)
        state, good = self._reject_outliers(with_tails, inliers)
        if state is with_tails or not good.any():
            return state, good
        at_rim = outliers.concentrate_at_rim(self.problem, good, inliers)
        ratio = MAX_RIM_RMS_RATIO if at_rim else MAX_TAIL_RMS_RATIO
        if not with_tails.converged:  # from nearer, it may
            with_tails = self.problem.solve(state, inliers, outliers.LEAST_SQUARES)
        if self._is_close(with_tails, inliers, state, good, ratio):
            return with_tails, inliers  # what was rejected are tails of the noise
        return state, good

    def _reject_outliers(self, state: State, inliers: Mask) -> tuple[State, Mask]:
        """Reject outliers and refit in turn; without outliers the result is `state` itself."""
        previous = inliers
        for _ in range(MAX_REJECTIONS - 1):
            good = outliers.inlier_mask(state, self.mask, previous, self.problem.width)
            if not good.any() or np.array_equal(previous, good):
                return state, good
            state = self.problem.solve(state, good, REJECTION)
            previous = good
        return state, previous  # a point or two change sides every time: either result is as good

    def _is_close(self, one: State, one_mask: Mask, other: State, other_mask: Mask, ratio: float) -> bool:
        """True if the rms of one fit over its points (v, n) is within `ratio` of another's over its own."""
        mean = np.mean(other.square[other_mask])
        return bool(np.mean(one.square[one_mask]) < ratio**2 * mean)

    def _least_squares(self, state: State) -> "_Found":
        """Least squares over all points, without the prior if the points determine every parameter."""
        problem = self.problem
        if self._is_observable(state):
            # With coefficients that nearly replace one another there are several optima: the lowest counts.
            model, obs, size = problem.model, problem.obs, problem.img_size
            other = (
                self.multistart.starts(problem)
                if model.start_families > 1
                else constrained(problem, initial_guess.from_vanishing_points(model, obs, size))
            )
            begun = [state, *(problem.at(s.k, s.poses) for s in other)]
            free = [problem.solve(s, self.mask, FREE) for s in begun]
            best = min(
                (s for s in free if s.converged and s.is_finite),
                key=lambda s: float(s.square.sum()),
                default=None,
            )
            if best is not None and not plausibility.folds(problem, best, self.mask):
                return self._result(best, self.mask, with_prior=False)
        state = problem.solve(state, self.mask, Options())
        return self._result(state, self.mask)

    def _evidence(self, state: State, good: Mask, sigma: float) -> robust_covariance.Evidence:
        rows, poses, obs, mask = state.rows, state.poses, self.problem.obs, self.mask
        taken: Mask = np.asarray(good.any(axis=1))
        if not taken.all():
            rows, poses = rows[:, :, taken], poses.subset(taken)
            obs, good, mask = obs.subset(np.flatnonzero(taken)), good[taken], mask[taken]
        labels = robust_covariance.same_pose_labels(poses, obs, good, self.problem.focal_widths(state.k))
        row = self.problem.row_positions[taken]
        effects = systematic_effects.displacements(rows[-POSE_SIZE - 1 : -1], poses, obs.points, row)
        evidence = robust_covariance.Evidence.of(rows, effects, poses, labels, used=good)
        limit = outliers.OUTLIER_SIGMAS * sigma
        seen = systematic_effects.explained_points(rows, effects, good, mask, sigma, limit)
        if np.array_equal(seen, good):
            return evidence
        more = robust_covariance.with_more_points(evidence.gram, rows, effects, labels, good, seen)
        return replace(evidence, of_effects=more)

    def _is_observable(self, state: State) -> bool:
        s = normal_equations.reduced_information(state.rows[:-1] * self.mask)
        scale = 1 / np.sqrt(np.maximum(np.diagonal(s), 1e-300))
        return bool(np.linalg.eigvalsh(s * scale[:, None] * scale)[0] > 1e-12)

    def _sigma(self, state: State, good: Mask) -> float:
        """Noise of one coordinate, px, corrected for the degrees of freedom."""
        used = 2 * float(good.sum())
        unknowns = len(state.rows) - 1 - POSE_SIZE + POSE_SIZE * int(good.any(axis=1).sum())
        free = used - unknowns
        noise = float(np.sqrt(state.square[good].sum() / max(free, 0.1 * used, 1.0)))
        return max(noise, levenberg_marquardt.ROUNDOFF * self.problem.width)

    def _result(
        self, state: State, good: Mask, mixed: MixedFit | None = None, *, with_prior: bool = True
    ) -> "_Found":
        """Check and describe the fit: errors over all points, covariance from the good ones (v, n).

        The state contains the board's shape if it was fitted (`mixed`). Raises CalibrationError
        ``not_converged`` or ``not_believable``.
        """
        if not state.converged:
            raise CalibrationError("not_converged", "the fit did not settle: the views contradict each other")
        problem, shape, optimum = self.problem, None, state
        if mixed:
            bent = mixed.problem.reshaped(optimum.k[:SHAPE_SIZE], problem.obs)
            problem, state = replace(problem, obs=bent), mixed.problem.of_camera(optimum)
        plausibility.check_result(problem, state, good, self.robust)
        state = self._resect_excluded_views(problem, state, good)
        k, mask, img_size = state.k, self.problem.obs.mask, self.problem.img_size
        # For a view that no pose explains, the model predicts arbitrary places: the image bounds distances.
        scale = 1.0 if problem.obs.scale is None else problem.obs.scale
        square = np.minimum(np.where(mask, state.square / scale**2, 0.0), float(np.hypot(*img_size)) ** 2)
        rms = float(np.sqrt(square.sum() / mask.sum()))
        sigma = self._sigma(state, good)
        # The noise has a lower limit, so that the prior keeps some weight against noise-free corners.
        believed = state.prior_jacobian.T @ state.prior_jacobian if with_prior else None
        if believed is not None:
            believed *= max(sigma, 1e-5 * img_size[0]) ** 2
        if mixed is None:
            spread = robust_covariance.estimate(self._evidence(state, good, sigma), sigma, believed)
            covariance, information = spread.covariance, spread.information
        else:
            spread = mixed.spread(optimum, good, sigma, self.mask)
            covariance = spread.covariance[SHAPE_SIZE:, SHAPE_SIZE:]
            information = marginal_information(spread.information, len(state.rows) - 1 - POSE_SIZE)
            shape = mixed.problem.shape(optimum)
            shape = replace(shape, covariance=frozen(spread.covariance[:SHAPE_SIZE, :SHAPE_SIZE]))
        if not (np.isfinite(rms) and np.isfinite(spread.covariance).all()):
            raise CalibrationError("not_believable", "the fit has no finite error")
        measured, back = self.order.points_back(mask), self.order.points_back
        signed = np.stack([back(-axis / scale) for axis in state.rows[-1]], axis=-1)  # observed - projected
        if problem.basis is not None:
            covariance = problem.basis @ covariance @ problem.basis.T
            inverse = np.linalg.pinv(problem.basis)
            information = inverse.T @ information @ inverse
        calibration = Calibration(
            camera=Camera.from_intrinsics(problem.model.name, k, img_size),
            poses=frozen(self.order.back(state.poses.vectors())),
            avg_reprojection_error=rms,
            view_errors=frozen(self.order.back(np.sqrt(square.sum(axis=1) / mask.sum(axis=1)))),
            covariance=frozen(covariance),
            information=frozen(information),
            noise=sigma,
            inflation=spread.inflation,
            residuals=tuple(frozen(e[m]) for e, m in zip(signed, measured, strict=True)),
            used=tuple(g[m] for g, m in zip(back(good), measured, strict=True)),
            prior_used=with_prior,
            cut_views=self._cut_reasons(good),
            board_shape=shape,
        )
        return _Found(problem, state, good, calibration)

    def _resect_excluded_views(self, problem: Problem, state: State, good: Mask) -> State:
        """Resect views that took no part, for their errors."""
        out = np.flatnonzero(~good.any(axis=1))
        if not out.size:
            return state
        poses, square = resection.resect(problem.model, state.k, problem.obs.subset(out))
        better = np.isfinite(square) & (square < np.where(problem.obs.mask, state.square, 0)[out].sum(axis=1))
        resected = state.poses.replace(out[better], poses.subset(better))
        return replace(problem.at(state.k, resected), converged=state.converged)

    def _cut_reasons(self, good: Mask) -> dict[int, str]:
        return {
            int(self.order.views[i]): "mirrored" if self.mirrored[i] else "outlier"
            for i in np.flatnonzero(~good.any(axis=1))
        }


@dataclass(frozen=True, eq=False)
class _Found:
    """Calibration and the optimum that it describes; `good` (v, n) are the points used."""

    problem: Problem
    state: State
    good: Mask
    calibration: Calibration
