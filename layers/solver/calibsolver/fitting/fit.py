"""From views to a calibration, or to the reason why there is none."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .. import models
from ..arrays import Array, Mask, frozen, symmetric_inverse
from ..camera import Camera
from ..errors import CalibrationError
from ..models import Model
from ..view import View
from . import (
    initial_guess,
    levenberg_marquardt,
    normal_equations,
    outliers,
    plausibility,
    prior,
    resection,
    validation,
)
from .calibration import Calibration
from .levenberg_marquardt import Options, Problem, State
from .multistart import APPROACH, Approach
from .normal_equations import Poses
from .observations import Order
from .validation import MIN_POINTS, check

__all__ = ["MIN_POINTS", "check", "fit"]

HARMLESS = 1.1
"""Least squares over all but wild points may have this many times the rms of those kept."""
SMOOTH = 4.0
"""Least squares over all points may have this many times the rms of those kept: the model is a little too
simple. More than that, and the points cut were wrong."""
ROUNDS = 6
"""Cuts at most."""
FREE = Options(with_prior=False, iterations=400, tolerance=1e-15)
"""Least squares alone may wind through long valleys."""


def fit(
    views: Sequence[View],
    img_size: tuple[int, int],
    model: str = "rectilinear",
    robust: bool = True,
    *,
    start: Camera | None = None,
) -> Calibration:
    """Fit a camera model to views of a planar board.

    Parameters
    ----------
    views
        At least one; each with at least six points that do not lie on a line.
    img_size
        Width and height, px.
    model
        One of `models.NAMES`.
    robust
        Huber weights on the way, then points beyond 4 sigma are cut and the rest fitted by least squares
        together with the model's weak prior. Otherwise plain least squares over all points; with the prior
        only where the points leave something open.
    start
        A camera that may be near: where the fit starts first. The result does not depend on it.

    Raises
    ------
    CalibrationError
        ``no_views``, ``too_few_points``, ``degenerate``, ``not_planar``, ``out_of_range``, ``mirrored``,
        ``unknown_model``, ``no_fit``, ``not_converged`` or ``not_believable``: never is nonsense returned.
    """
    law = models.get(model)
    given = check(views, img_size)
    turned = validation.mirrored(given)
    if turned.any() and not robust:
        raise CalibrationError("mirrored", f"view {int(np.argmax(turned))} shows the board mirrored")
    # In one order, whichever the views came in: rounding, too, is then the same.
    obs, order = given.ordered()
    # Far from the solution numbers may overflow; every step is tested before it is taken.
    with np.errstate(all="ignore"):
        return _Fit(Problem(law, obs, img_size), order, turned[order.views], robust, start).run()


def fit_again(views: Sequence[View], near: Camera, poses: Array) -> Calibration:
    """Fit views of which camera and poses (v, 6) are nearly known: robustly, from there alone.

    For parts of what was fitted before; raises as `fit` does.
    """
    law, given = models.get(near.model), check(views, near.img_size)
    obs, order = given.ordered()
    turned = validation.mirrored(given)[order.views]
    problem = Problem(law, obs, near.img_size)
    with np.errstate(all="ignore"):
        state = problem.at(near.intrinsics, Poses.of_vectors(poses[order.views]))
        return _Fit(problem, order, turned, True, near).run(state)


@dataclass(frozen=True, eq=False)
class _Fit:
    problem: Problem
    order: Order
    turned: Mask
    robust: bool
    known: Camera | None

    @property
    def model(self) -> Model:
        return self.problem.model

    @property
    def width(self) -> int:
        return self.problem.img_size[0]

    @cached_property
    def mask(self) -> Mask:
        """Points (v, n) that may take part."""
        measured = self.problem.obs.mask
        return measured & ~self.turned[:, None] if self.turned.any() else measured

    @cached_property
    def approach(self) -> Approach:
        """The way to near the optimum."""
        return Approach(self.problem, self.mask, self.known)

    def run(self, near: State | None = None) -> Calibration:
        """Fit, from `near` alone where it is given."""
        try:
            return self.finish(near or self.approach.run())
        except np.linalg.LinAlgError:
            raise CalibrationError("not_believable", "the views leave the camera undetermined") from None

    def finish(self, state: State) -> Calibration:
        """From near the optimum to a result: outliers cut, least squares."""
        if not self.robust:
            return self.plain(state)
        problem, obs, mask, size = self.problem, self.problem.obs, self.mask, self.problem.img_size
        begun, tame = state, outliers.kept(state, mask, mask, outliers.WILD, size)
        if outliers.systematic(tame, mask, obs, size):
            # It may be the model that fails at the rim: then every point counts, or it would fail unseen.
            whole = self.whole(begun, self.approach.everything)
            if np.mean(whole.square[mask]) < SMOOTH**2 * np.mean(state.square[tame]):
                return self.result(whole, mask, with_prior=True)
        good = tame
        for _ in range(ROUNDS):
            if not good.any():
                return self.result(state, good, with_prior=True)  # refused there
            state = problem.solve(state, outliers.weights(good), Options())
            previous, good = good, outliers.kept(state, mask, good, outliers.CUT, size)
            if np.array_equal(previous, good):
                break
        else:  # where a point or two change sides every time, either is as good
            good = previous
        if not np.array_equal(tame, good):
            # The same again; and points that hardly spoil the fit are tails, not mistakes: they count too.
            worse = SMOOTH if outliers.systematic(good, tame, obs, size) else HARMLESS
            whole = problem.solve(state, outliers.weights(tame), Options())
            if np.mean(whole.square[tame]) < worse**2 * np.mean(state.square[good]):
                state, good = whole, tame
        return self.result(state, good, with_prior=True)

    def whole(self, state: State, weights: Array) -> State:
        """Least squares over points of weight (v, n), begun anew from the intrinsics of `state`."""
        first = initial_guess.mended(
            self.model, self.problem.obs, initial_guess.at(self.model, self.problem.obs, state.k)
        )
        state = self.problem.solve(self.problem.at(first.k, first.poses), weights, APPROACH)
        return self.problem.solve(state, weights, Options())

    def plain(self, state: State) -> Calibration:
        """Least squares over all points, without the prior where the points carry every parameter."""
        problem = self.problem
        if self.carried(state):
            # With coefficients that nearly replace one another there are several optima: the lowest counts.
            law, obs, size = problem.model, problem.obs, problem.img_size
            other = (
                self.approach.starts(problem)
                if law.start_families > 1
                else initial_guess.direct(law, obs, size)
            )
            begun = [state, *(problem.at(s.k, s.poses) for s in other)]
            free = [problem.solve(s, self.approach.everything, FREE) for s in begun]
            best = min((s for s in free if s.converged and s.is_finite), key=cost, default=None)
            if best is not None and plausibility.folded(problem, best, self.mask) <= plausibility.FOLDED:
                return self.result(best, self.mask, with_prior=False)
        return self.result(
            problem.solve(state, self.approach.everything, Options()), self.mask, with_prior=True
        )

    def information(self, state: State, good: Mask) -> Array:
        """Sum up what the good points (v, n) tell of the intrinsics at unit noise, (p, p)."""
        rows = state.rows[:-1]
        weighted = rows if good.all() else rows * outliers.weights(good) ** 0.5
        return normal_equations.reduced_information(weighted)

    def carried(self, state: State) -> bool:
        """Whether the data alone determine every parameter."""
        s = self.information(state, self.mask)
        scale = 1 / np.sqrt(np.maximum(np.diagonal(s), 1e-300))
        return bool(np.linalg.eigvalsh(s * scale[:, None] * scale)[0] > 1e-12)

    def sigma(self, state: State, good: Mask) -> float:
        """Noise of one coordinate, px: least squares estimate, corrected for the degrees of freedom."""
        used = 2 * float(good.sum())
        free = used - self.model.size - 6 * float(good.any(axis=1).sum())
        noise = float(np.sqrt(state.square[good].sum() / max(free, 0.1 * used, 1.0)))
        return max(noise, levenberg_marquardt.ROUNDOFF * self.width)

    def result(self, state: State, good: Mask, *, with_prior: bool) -> Calibration:
        if not state.converged:
            raise CalibrationError("not_converged", "the fit did not settle: the views contradict each other")
        plausibility.demand(self.problem, state, good, self.robust)
        state = self.left_out_posed(state, good)
        k, mask, img_size = state.k, self.problem.obs.mask, self.problem.img_size
        # No point is farther off than the image is large: of a view that no pose explains the model says
        # anything.
        square = np.minimum(np.where(mask, state.square, 0.0), float(np.hypot(*img_size)) ** 2)
        rms = float(np.sqrt(square.sum() / mask.sum()))
        sigma = self.sigma(state, good)
        s = self.information(state, good)
        if with_prior:
            # Below any detector's noise it keeps some weight: corners without any would leave nothing of it.
            s = s + max(sigma, 1e-5 * img_size[0]) ** 2 * prior.information(self.model, k, img_size)
        covariance = sigma**2 * symmetric_inverse(s)
        if not (np.isfinite(rms) and np.isfinite(covariance).all()):
            raise CalibrationError("not_believable", "the fit has no finite error")
        measured, back = self.order.points_back(mask), self.order.points_back
        return Calibration(
            camera=Camera.from_intrinsics(self.model.name, k, img_size),
            poses=frozen(self.order.back(state.poses.vectors())),
            avg_reprojection_error=rms,
            view_errors=frozen(self.order.back(np.sqrt(square.sum(axis=1) / mask.sum(axis=1)))),
            covariance=frozen(covariance),
            noise=sigma,
            residuals=tuple(frozen(e[m]) for e, m in zip(back(state.length), measured, strict=True)),
            used=tuple(g[m] for g, m in zip(back(good), measured, strict=True)),
            prior_used=with_prior,
            cut_views=self.reasons(good),
        )

    def left_out_posed(self, state: State, good: Mask) -> State:
        """Give views that took no part the poses that suit them best: their errors are reported, too."""
        out = np.flatnonzero(~good.any(axis=1))
        if not out.size:
            return state
        poses, square = resection.resect(self.model, state.k, self.problem.obs.subset(out))
        better = np.isfinite(square) & (
            square < np.where(self.problem.obs.mask, state.square, 0)[out].sum(axis=1)
        )
        r, t = state.poses.r.copy(), state.poses.t.copy()
        r[out[better]], t[out[better]] = poses.r[better], poses.t[better]
        return replace(self.problem.at(state.k, Poses(r, t)), converged=state.converged)

    def reasons(self, good: Mask) -> dict[int, str]:
        """Why views (by number) are wholly left out."""
        return {
            int(self.order.views[i]): "mirrored" if self.turned[i] else "outlier"
            for i in np.flatnonzero(~good.any(axis=1))
        }


def cost(state: State) -> float:
    """Sum of the squared residuals, padding and all: for comparison only."""
    return float(state.square.sum())
