"""Multistart: from several initial guesses to near the optimum, robustly, whichever views are bad."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from .. import deadline
from ..arrays import Mask
from ..camera import Camera
from ..errors import CalibrationError
from . import homography, initial_guess, outliers, plausibility
from .levenberg_marquardt import Options, Problem, State

MAX_TRUSTED_RMS_WIDTHS = 0.002
"""Trimmed rms / image width above which other starts are tried."""
TOWARDS_OPTIMUM = Options(robust=True, tolerance=1e-3, damping=1e-5, one_step=True, patient=True)
"""Always robust: one bad view must not turn the first steps."""
MAX_PRIOR_Z = 3.0
"""Sigmas of the prior by which aspect and principal point may differ before other starts are tried."""
MAX_REINITIALIZATIONS = 3
INLIER_MEDIANS = 5.0
SAME_OPTIMUM = 0.02
"""Relative difference of focal length, principal point (in widths) and rms within which optima are equal."""
MAX_DIRECT_VIEWS = 24
"""Views up to which the likeliest start is followed with all of them, without a trial on some."""
MAX_SWEEP_STARTS = 4


@dataclass(frozen=True, eq=False)
class MultiStart:
    """Several starts of one fit, the best of which is followed.

    `mask` (v, n) are points that may take part, `known` is a camera that may be near. If `rejection_follows`,
    a single optimum keeps its gross outliers.
    """

    problem: Problem
    mask: Mask
    known: Camera | None
    rejection_follows: bool = False

    def run(self) -> State:
        """Solve from several starts to near the optimum and return the best."""
        obs, problem = self.problem.obs, self.problem
        direct = initial_guess.MAX_TRIAL_VIEWS < obs.view_count <= MAX_DIRECT_VIEWS
        if direct and problem.model.start_families == 1:
            first = next(self.starts(problem), None)
            begun = None if first is None else self.follow(problem, first, self.mask)
            if begun is not None and self.is_clear(problem, begun, self.mask):
                return begun
        trial_views = initial_guess.subsample_views(obs, self.mask)
        if trial_views is None:
            return self.rank_optima(problem, self.mask)[0]
        trial = replace(problem, obs=obs.subset(trial_views))
        found = self.rank_optima(trial, self.mask[trial_views])
        # Where a few views leave it open which camera it is, all of them decide.
        states = []
        followed = found[:1] if self.within_prior(found[0]) else found[:2]
        if len(followed) > 1 and self.is_same(found[0], found[1], self.mask[trial_views]):
            followed = followed[:1]
        for k in [state.k for state in followed]:
            first = initial_guess.with_robust_poses(problem.model, obs, k)
            state = problem.at(first.k, first.poses)
            # Intrinsics are approximately known, so gross outliers can be excluded already.
            middle = homography.medians(state.square, self.mask)
            good = self.mask & (state.square <= INLIER_MEDIANS**2 * middle[:, None])
            state = problem.solve(state, good, TOWARDS_OPTIMUM)
            states.append(reinitialize_outlying_poses(problem, state, good, self.mask))
        return outliers.rank_states(states, problem, self.mask)[0]

    def rank_optima(self, trial: Problem, mask: Mask) -> list[State]:
        """Rank the optima that the starts lead to, the best first.

        The search stops at an optimum within the prior, or when a second start leads to the best one, except
        the `known` camera: the result must not depend on it.
        """
        found: list[State] = []
        repeats = 2 if self.known is None else 3
        families = trial.model.start_families
        is_single = self.rejection_follows and trial is self.problem and families == 1
        for first in self.starts(trial):
            state = self.follow(trial, first, mask)
            if state is None:
                continue
            if is_single and not found and self.is_clear(trial, state, mask):
                return [state]
            state = refit_without_gross_outliers(trial, state, mask)
            best = min(found, key=lambda other: outliers.trimmed_rms(other, mask), default=None)
            found.append(state)
            again = best is not None and len(found) >= repeats and self.is_same(state, best, mask)
            if (
                len(found) >= families
                and (self.within_prior(state) or again)
                and self.is_close(trial, state, mask)
            ):
                break
        if not found:
            raise CalibrationError("no_fit", "no camera explains these views")
        return outliers.rank_states(found, trial, mask)

    def starts(self, trial: Problem) -> Iterator[initial_guess.Start]:
        """Yield the starts, the likeliest first, with intrinsics that satisfy the problem's constraint."""
        yield from constrained(trial, self._unconstrained_starts(trial))

    def _unconstrained_starts(self, trial: Problem) -> Iterator[initial_guess.Start]:
        model, obs, size = trial.model, trial.obs, trial.img_size
        if self.known is not None and self.known.img_size == size:
            yield initial_guess.at(model, obs, initial_guess.convert_intrinsics(model, self.known))
        yield from initial_guess.from_vanishing_points(model, obs, size)
        for start in initial_guess.focal_sweep(model, obs, size)[:MAX_SWEEP_STARTS]:
            yield initial_guess.with_robust_poses(model, obs, start.k)

    def follow(self, problem: Problem, first: initial_guess.Start, mask: Mask) -> State | None:
        """Solve from a start to near the optimum; None if it diverges."""
        deadline.check()
        state = problem.at(first.k, first.poses)
        good = mask if first.weights is None else mask & (first.weights > 0)
        if not (state.is_finite and good.any()):
            return None
        state = problem.solve(state, good, TOWARDS_OPTIMUM)
        state = reinitialize_outlying_poses(problem, state, mask, mask)
        return state if state.is_finite else None

    def is_close(self, problem: Problem, state: State, mask: Mask) -> bool:
        """True if an optimum explains most points (v, n), all within the model's domain."""
        rms = outliers.trimmed_rms(state, mask)
        return rms < MAX_TRUSTED_RMS_WIDTHS * problem.width and not plausibility.folds(problem, state, mask)

    def is_clear(self, problem: Problem, state: State, mask: Mask) -> bool:
        """True if an optimum explains the views, and the camera is like others."""
        return self.within_prior(state) and self.is_close(problem, state, mask)

    def is_same(self, one: State, other: State, mask: Mask) -> bool:
        """True if two starts led towards the same optimum."""
        change = np.abs(one.k[:4] - other.k[:4]) / (*other.k[:2], *(2 * [self.problem.img_size[0]]))
        quotient = outliers.trimmed_rms(one, mask) / outliers.trimmed_rms(other, mask)
        return bool(change.max() < SAME_OPTIMUM and abs(quotient - 1) < SAME_OPTIMUM)

    def within_prior(self, state: State) -> bool:
        """True if the camera is like others; else it may be a local minimum next to the right one."""
        return bool(np.abs(state.prior_residuals[1:4]).max() < MAX_PRIOR_Z)


def constrained(problem: Problem, starts: Iterable[initial_guess.Start]) -> Iterator[initial_guess.Start]:
    """Yield starts whose intrinsics satisfy the constraint of a problem, with new poses."""
    for start in starts:
        if problem.origin is None:
            yield start
        else:
            yield initial_guess.with_robust_poses(problem.model, problem.obs, problem.nearest(start.k))


def reinitialize_outlying_poses(problem: Problem, state: State, good: Mask, mask: Mask) -> State:
    """Reinitialize the poses of views that fit badly from the LMedS inliers among their points.

    Robust weights do not recover a view in which a row of corners has wrong names.
    """
    for _ in range(MAX_REINITIALIZATIONS):
        bad = outliers.views_beyond_threshold(state, mask)
        if not bad.size:
            break
        part = replace(problem, obs=problem.obs.subset(bad))
        rays = initial_guess.unproject_observations(problem.model, part.obs, state.k)
        homographies, _ = homography.fit_homographies_lmeds(part.obs.points, rays, mask[bad], 0.0)
        poses = homographies.poses(part.obs.points[:, 2, 0])
        square = part.at(state.k, poses).square
        middle = homography.medians(square, mask[bad])
        better = middle < homography.medians(state.square[bad], mask[bad])
        if not better.any():
            break
        good = good.copy()
        all_poses = state.poses.replace(bad[better], poses.subset(better))
        near = square <= INLIER_MEDIANS**2 * middle[:, None]
        good[bad[better]] = (near & mask[bad])[better]
        state = problem.solve(problem.at(state.k, all_poses), good, TOWARDS_OPTIMUM)
    return state


def refit_without_gross_outliers(problem: Problem, state: State, mask: Mask) -> State:
    """Refit without gross outliers, which would bias the way to the optimum."""
    good = outliers.inlier_mask(state, mask, mask, problem.width, outliers.GROSS_OUTLIER_SIGMAS)
    if np.array_equal(good, mask):
        return state
    return problem.solve(state, good, Options(tolerance=1e-4))
