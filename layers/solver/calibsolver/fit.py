"""From views to a calibration, or to the reason why there is none."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from . import checks, lm, majority, models, normal, outliers, plausible, prior, score, start
from .arrays import Array, Mask, frozen, symmetric_inverse
from .calibration import Calibration
from .camera import Camera
from .checks import MIN_POINTS, check
from .errors import CalibrationError
from .lm import Options, Problem, State
from .models import Model
from .normal import Poses
from .observations import Order
from .view import View

__all__ = ["MIN_POINTS", "check", "fit"]

DOUBTFUL = 0.002
"""Above this share of the image width other starts are tried."""
HARMLESS = 1.1
"""Least squares over all but wild points may have this many times the rms of those kept."""
SMOOTH = 4.0
"""Least squares over all points may have this many times the rms of those kept: the model is a little too
simple. More than that, and the points cut were wrong."""
APPROACH = Options(robust=True, tolerance=1e-3, damping=1e-6)
"""The way there is always robust: one bad view must not turn the first steps."""
SURPRISE = 3.0
"""Other starts are tried too where pixels are this many sigmas from square, or the centre from the middle."""
ROUNDS = 6
"""Cuts at most."""
FREE = Options(with_prior=False, iterations=400, tolerance=1e-15)
"""Least squares alone may wind through long valleys."""
AGAIN = 3
"""Times that views which fit badly are posed anew."""
AGREES = 5.0
"""Median errors within which a point of such a view agrees with most of its points."""
TRIES = 4
"""Rungs of the ladder that are followed at most."""


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
    turned = checks.mirrored(given)
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
    turned = checks.mirrored(given)[order.views]
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
    def everything(self) -> Array:
        """Weights (v, n) with all of them."""
        return outliers.weights(self.mask)

    def run(self, near: State | None = None) -> Calibration:
        """Fit, from `near` alone where it is given."""
        try:
            return self.finish(near or self.approach())
        except np.linalg.LinAlgError:
            raise CalibrationError("not_believable", "the views leave the camera undetermined") from None

    def approach(self) -> State:
        """From several starts to near the optimum; the best of them."""
        obs, problem = self.problem.obs, self.problem
        few = start.few(obs, self.mask)
        if few is None:
            return self.ranked(problem, self.everything, self.mask)[0]
        trial = Problem(problem.model, obs.subset(few), problem.img_size)
        found = self.ranked(trial, self.everything[few], self.mask[few])
        # Where a few views leave it open which camera it is, all of them decide.
        states = []
        for k in [state.k for state in found[: 1 if self.ordinary(found[0]) else 2]]:
            first = start.mended(problem.model, obs, start.at(problem.model, obs, k))
            state = problem.at(first.k, first.poses)
            # The camera is known about; what is far off already would only bend it on the way.
            near = state.square <= AGREES**2 * majority.medians(state.square, self.mask)[:, None]
            weights = outliers.weights(near & self.mask)
            state = problem.solve(state, weights, APPROACH)
            states.append(self.posed_anew(problem, state, weights, self.mask))
        return outliers.ranked(states, problem, self.mask)[0]

    def ranked(self, trial: Problem, weights: Array, mask: Mask) -> list[State]:
        """Optima that the starts lead to, the best first; no more than it takes to find an ordinary one."""
        found: list[State] = []
        for first in self.starts(trial):
            state = trial.at(first.k, first.poses)
            good = mask if first.weights is None else mask & (first.weights > 0)
            if not (state.finite and good.any()):
                continue
            state = trial.solve(state, outliers.weights(good), APPROACH)
            state = self.posed_anew(trial, state, weights, mask)
            if not state.finite:
                continue
            found.append(state)
            if (
                len(found) >= self.model.families
                and self.ordinary(state)
                and outliers.level(state, mask) < DOUBTFUL * self.width
                and plausible.folded(trial, state, mask) <= plausible.FOLDED
            ):
                break
        if not found:
            raise CalibrationError("no_fit", "no camera explains these views")
        return outliers.ranked(found, trial, mask)

    def starts(self, trial: Problem) -> Iterator[start.Start]:
        """Where to begin, the likeliest first."""
        model, obs, size = trial.model, trial.obs, trial.img_size
        if self.known is not None and self.known.img_size == size:
            yield start.at(model, obs, start.like(model, self.known))
        yield from start.direct(model, obs, size)
        for rung in start.ladder(model, obs, size)[:TRIES]:
            yield start.mended(model, obs, rung)

    def ordinary(self, state: State) -> bool:
        """Whether this is a camera like others; a strange one may be a local minimum beside the right one."""
        return bool(np.abs(state.belief[1:4]).max() < SURPRISE)

    def finish(self, state: State) -> Calibration:
        """From near the optimum to a result: outliers cut, least squares."""
        if not self.robust:
            return self.plain(state)
        problem, obs, mask, size = self.problem, self.problem.obs, self.mask, self.problem.img_size
        begun, tame = state, outliers.kept(state, mask, mask, outliers.WILD, size)
        if outliers.systematic(tame, mask, obs, size):
            # It may be the model that fails at the rim: then every point counts, or it would fail unseen.
            whole = self.whole(begun, self.everything)
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
        first = start.mended(self.model, self.problem.obs, start.at(self.model, self.problem.obs, state.k))
        state = self.problem.solve(self.problem.at(first.k, first.poses), weights, APPROACH)
        return self.problem.solve(state, weights, Options())

    def tamed(self, problem: Problem, state: State, mask: Mask) -> State:
        """Fit without what is certainly wrong, so that it no longer bends the way."""
        good = outliers.kept(state, mask, mask, outliers.WILD, problem.img_size)
        if np.array_equal(good, mask):
            return state
        return problem.solve(state, outliers.weights(good), Options(tolerance=1e-4))

    def posed_anew(self, problem: Problem, state: State, weights: Array, mask: Mask) -> State:
        """Let views that fit badly start again, from what the majority of their points say.

        A row of corners under wrong names pulls its view so far that robust weights alone do not bring it
        back: to fit all points a little is cheaper than to fit most and miss some by far.
        """
        for _ in range(AGAIN):
            bad = outliers.unfit(state, mask)
            if not bad.size:
                break
            part = Problem(problem.model, problem.obs.subset(bad), problem.img_size)
            rays = start.seen(problem.model, part.obs, state.k)
            planes, _ = majority.planes(part.obs.points, rays, mask[bad], 0.0)
            poses = planes.poses(part.obs.points[:, 2, 0])
            square = part.at(state.k, poses).square
            middle = majority.medians(square, mask[bad])
            better = middle < majority.medians(state.square[bad], mask[bad])
            if not better.any():
                break
            r, t, weights = state.poses.r.copy(), state.poses.t.copy(), weights.copy()
            r[bad[better]], t[bad[better]] = poses.r[better], poses.t[better]
            near = square <= AGREES**2 * middle[:, None]
            weights[bad[better]] = (near & mask[bad])[better]
            state = problem.solve(problem.at(state.k, Poses(r, t)), weights, APPROACH)
        return self.tamed(problem, state, mask)

    def plain(self, state: State) -> Calibration:
        """Least squares over all points, without the prior where the points carry every parameter."""
        problem = self.problem
        if self.carried(state):
            # With coefficients that nearly replace one another there are several optima: the lowest counts.
            law, obs, size = problem.model, problem.obs, problem.img_size
            other = self.starts(problem) if law.families > 1 else start.direct(law, obs, size)
            begun = [state, *(problem.at(s.k, s.poses) for s in other)]
            free = [problem.solve(s, self.everything, FREE) for s in begun]
            best = min((s for s in free if s.converged and s.finite), key=cost, default=None)
            if best is not None and plausible.folded(problem, best, self.mask) <= plausible.FOLDED:
                return self.result(best, self.mask, with_prior=False)
        return self.result(problem.solve(state, self.everything, Options()), self.mask, with_prior=True)

    def information(self, state: State, good: Mask) -> Array:
        """Sum up what the good points (v, n) tell of the intrinsics at unit noise, (p, p)."""
        rows = state.rows[:-1]
        weighted = rows if good.all() else rows * outliers.weights(good) ** 0.5
        return normal.told(weighted, self.model.size)

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
        return max(noise, lm.ROUNDING * self.width)

    def result(self, state: State, good: Mask, *, with_prior: bool) -> Calibration:
        if not state.converged:
            raise CalibrationError("not_converged", "the fit did not settle: the views contradict each other")
        plausible.demand(self.problem, state, good, self.robust)
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
        poses, square = score.resect(self.model, state.k, self.problem.obs.subset(out))
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
