"""From several starts to near the optimum: robustly, and whichever views are bad."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Array, Mask
from ..camera import Camera
from ..errors import CalibrationError
from ..models import Model
from . import initial_guess, outliers, plausibility, robust_homography
from .levenberg_marquardt import Options, Problem, State
from .normal_equations import Poses

DOUBTFUL = 0.002
"""Above this share of the image width other starts are tried."""
APPROACH = Options(robust=True, tolerance=1e-3, damping=1e-6)
"""The way there is always robust: one bad view must not turn the first steps."""
SURPRISE = 3.0
"""Other starts are tried too where pixels are this many sigmas from square, or the centre from the middle."""
AGAIN = 3
"""Times that views which fit badly are posed anew."""
AGREES = 5.0
"""Median errors within which a point of such a view agrees with most of its points."""
TRIES = 4
"""Rungs of the ladder that are followed at most."""


@dataclass(frozen=True, eq=False)
class Approach:
    """The way to one fit's optimum."""

    problem: Problem
    mask: Mask
    """Points (v, n) that may take part."""
    known: Camera | None
    """A camera that may be near."""

    @property
    def model(self) -> Model:
        """The law that is fitted."""
        return self.problem.model

    @cached_property
    def everything(self) -> Array:
        """Weights (v, n) with all points."""
        return outliers.weights(self.mask)

    def run(self) -> State:
        """From several starts to near the optimum; the best of them."""
        obs, problem = self.problem.obs, self.problem
        few = initial_guess.few(obs, self.mask)
        if few is None:
            return self.ranked(problem, self.everything, self.mask)[0]
        trial = Problem(problem.model, obs.subset(few), problem.img_size)
        found = self.ranked(trial, self.everything[few], self.mask[few])
        # Where a few views leave it open which camera it is, all of them decide.
        states = []
        for k in [state.k for state in found[: 1 if self.ordinary(found[0]) else 2]]:
            first = initial_guess.mended(problem.model, obs, initial_guess.at(problem.model, obs, k))
            state = problem.at(first.k, first.poses)
            # The camera is known about; what is far off already would only bend it on the way.
            near = state.square <= AGREES**2 * robust_homography.medians(state.square, self.mask)[:, None]
            weights = outliers.weights(near & self.mask)
            state = problem.solve(state, weights, APPROACH)
            states.append(posed_anew(problem, state, weights, self.mask))
        return outliers.ranked(states, problem, self.mask)[0]

    def ranked(self, trial: Problem, weights: Array, mask: Mask) -> list[State]:
        """Optima that the starts lead to, the best first; no more than it takes to find an ordinary one."""
        found: list[State] = []
        for first in self.starts(trial):
            state = trial.at(first.k, first.poses)
            good = mask if first.weights is None else mask & (first.weights > 0)
            if not (state.is_finite and good.any()):
                continue
            state = trial.solve(state, outliers.weights(good), APPROACH)
            state = posed_anew(trial, state, weights, mask)
            if not state.is_finite:
                continue
            found.append(state)
            if (
                len(found) >= self.model.start_families
                and self.ordinary(state)
                and outliers.level(state, mask) < DOUBTFUL * self.problem.img_size[0]
                and plausibility.folded(trial, state, mask) <= plausibility.FOLDED
            ):
                break
        if not found:
            raise CalibrationError("no_fit", "no camera explains these views")
        return outliers.ranked(found, trial, mask)

    def starts(self, trial: Problem) -> Iterator[initial_guess.Start]:
        """Order starting points, the likeliest first."""
        model, obs, size = trial.model, trial.obs, trial.img_size
        if self.known is not None and self.known.img_size == size:
            yield initial_guess.at(model, obs, initial_guess.like(model, self.known))
        yield from initial_guess.direct(model, obs, size)
        for rung in initial_guess.ladder(model, obs, size)[:TRIES]:
            yield initial_guess.mended(model, obs, rung)

    def ordinary(self, state: State) -> bool:
        """Whether this is a camera like others; a strange one may be a local minimum beside the right one."""
        return bool(np.abs(state.prior_residuals[1:4]).max() < SURPRISE)


def posed_anew(problem: Problem, state: State, weights: Array, mask: Mask) -> State:
    """Let views that fit badly start again, from what the majority of their points say.

    A row of corners under wrong names pulls its view so far that robust weights alone do not bring it
    back: to fit all points a little is cheaper than to fit most and miss some by far.
    """
    for _ in range(AGAIN):
        bad = outliers.unfit(state, mask)
        if not bad.size:
            break
        part = Problem(problem.model, problem.obs.subset(bad), problem.img_size)
        rays = initial_guess.seen(problem.model, part.obs, state.k)
        planes, _ = robust_homography.planes(part.obs.points, rays, mask[bad], 0.0)
        poses = planes.poses(part.obs.points[:, 2, 0])
        square = part.at(state.k, poses).square
        middle = robust_homography.medians(square, mask[bad])
        better = middle < robust_homography.medians(state.square[bad], mask[bad])
        if not better.any():
            break
        r, t, weights = state.poses.r.copy(), state.poses.t.copy(), weights.copy()
        r[bad[better]], t[bad[better]] = poses.r[better], poses.t[better]
        near = square <= AGREES**2 * middle[:, None]
        weights[bad[better]] = (near & mask[bad])[better]
        state = problem.solve(problem.at(state.k, Poses(r, t)), weights, APPROACH)
    return tamed(problem, state, mask)


def tamed(problem: Problem, state: State, mask: Mask) -> State:
    """Fit without what is certainly wrong, so that it no longer bends the way."""
    good = outliers.kept(state, mask, mask, outliers.WILD, problem.img_size)
    if np.array_equal(good, mask):
        return state
    return problem.solve(state, outliers.weights(good), Options(tolerance=1e-4))
