"""Joint fit of a rig: intrinsics, relative poses and board poses, by the solver of one camera.

The residuals of cameras with more noise weigh less in proportion.

A board that moved between the images of two cameras makes a moment whose views are right, but not together,
and a fit to few moments bends to it. But then the rig has far more noise than its single cameras, and without
that view it has not. So views are left out one at a time.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..arrays import Array, IntArray, Mask, frozen
from ..camera import Camera
from ..errors import CalibrationError, undetermined
from ..fitting import levenberg_marquardt, outliers, plausibility, robust_covariance, systematic_effects
from ..fitting.fit import MIN_SHAPE_VIEWS
from ..fitting.homography import medians
from ..fitting.levenberg_marquardt import NOISE_FLOOR, Options, State
from ..fitting.mixed_fit import MixedFit
from ..fitting.mixed_model import SHAPE_SIZE
from ..fitting.multistart import TOWARDS_OPTIMUM
from ..fitting.normal_equations import Poses
from ..fitting.validation import MIN_POINTS
from ..rotation import vector
from . import transfer
from .calibration import RigCalibration
from .problem import Moment, RigProblem, thin, unlinked_cameras
from .start import (
    LocatedMoment,
    RigidMotion,
    Single,
    Specification,
    fit_alone,
    locate_boards,
    resected,
    stack,
    start,
    symmetries,
)

MAX_JOINT_NOISE_RATIO = 1.5
"""Noise of the rig / noise of its single cameras, from which a contradicting view is searched."""
MIN_NOISE_DROP = 0.6
"""Noise of the rig without a view / with it, below which the view is set aside."""
MAX_START_MEDIANS = 3.0
"""Error of a moment under the start / that of the typical one, up to which its views agree."""
MIN_START_ERROR_WIDTHS = 1e-3
"""Error under the start / image width below which a view agrees."""
MAX_CANDIDATES = 12
MIN_RIG_CAMERAS, MAX_RIG_CAMERAS = 2, 8
MAX_MOMENTS = 1000
MAX_REJECTIONS = 6
MAX_UNSETTLED_ROUNDS = 3
"""Rounds without convergence after which the moments are taken to contradict each other."""
ROUND = Options(iterations=40, tolerance=1e-8)
"""Moments that agree need ten to twenty steps."""
MIN_OUTLIER_WIDTHS = 0.003
"""Distance / image width below which a single point of a good view is not an outlier."""
MAX_TAIL_RMS_RATIO = 1.1
"""Rms over all but gross outliers / rms of the inliers, up to which all of them count."""
MIN_MOMENTS_PER_LATE_VIEW = 4
"""Moments for each view that is set aside although no residual stands out."""
MAX_NOISE_RATIO = 4.0
"""Largest believed ratio of the noise of two cameras."""


@undetermined()
def fit(
    moments: Sequence[Moment],
    cameras: Sequence[Specification],
    robust: bool = True,
    *,
    starts: Mapping[int, Camera] | None = None,
    max_points: int | None = None,
    board_shape: bool = True,
) -> RigCalibration:
    """Fit a rig of cameras to moments.

    Parameters
    ----------
    moments
        Views of each pose of the board, held still, by the positions of their cameras, in any unit of length.
    cameras
        For each position the image size and the model to be fitted, or a `Camera` whose intrinsics are held.
    robust
        Set aside views that contradict the rig, and leave out points beyond 4 sigma. Otherwise plain least
        squares over all points, and a view that no camera could have seen raises.
    starts
        Cameras that may be near, by position.
    max_points
        Points to which views are thinned.
    board_shape
        As for `calibsolver.fit`, of the one board that all cameras see.

    Raises
    ------
    CalibrationError
        As `calibsolver.fit`, the camera named; ``bad_rig`` if cameras or positions make no sense,
        ``unlinked`` if some cameras share no moment with the others.
    """
    moments = [dict(moment) for moment in moments]
    _check(moments, cameras)
    board_shape = board_shape and not any(view.flat for moment in moments for view in moment.values())
    if max_points is not None:
        moments = thin(moments, max_points)
    with np.errstate(all="ignore"):  # far from the solution numbers may overflow; every step is tested
        starts = starts or {}
        alone = [fit_alone(moments, i, each, robust, starts.get(i)) for i, each in enumerate(cameras)]
        usable = {m: each for m, each in enumerate(resected(moments, dict(enumerate(alone)))) if each.poses}
        motions, located = start([each.camera for each in alone], list(usable.values()))
        return _RigFit(moments, alone, list(usable), motions, located, robust, board_shape).run()


def _check(moments: Sequence[Moment], cameras: Sequence[Specification]) -> None:
    if not MIN_RIG_CAMERAS <= len(cameras) <= MAX_RIG_CAMERAS:
        raise CalibrationError(
            "bad_rig", f"a rig has {MIN_RIG_CAMERAS} to {MAX_RIG_CAMERAS} cameras, not {len(cameras)}"
        )
    if not 1 <= len(moments) <= MAX_MOMENTS:
        raise CalibrationError(
            "no_views", f"a rig is fitted to 1 to {MAX_MOMENTS} moments, not {len(moments)}"
        )
    for m, moment in enumerate(moments):
        for position in moment:
            if position not in range(len(cameras)):
                raise CalibrationError(
                    "bad_rig", f"moment {m} has a view of camera {position}: there are {len(cameras)}"
                )
    for position in range(len(cameras)):
        if not any(position in moment for moment in moments):
            raise CalibrationError("unlinked", f"camera {position} has no view")


@dataclass(frozen=True, eq=False)
class _RigFit:
    """One joint fit. `linked`: numbers of the moments that are `located`."""

    given: Sequence[Moment]
    alone: Sequence[Single]
    linked: Sequence[int]
    motions: Sequence[RigidMotion]
    located: Sequence[LocatedMoment]
    robust: bool
    board_shape: bool

    @cached_property
    def noises(self) -> Array:
        """Noise (c,) of one coordinate of a corner of each camera, px."""
        result = np.maximum([each.noise for each in self.alone], 1e-12)
        return np.asarray(np.minimum(result, MAX_NOISE_RATIO * result.min()))

    @cached_property
    def noise(self) -> float:
        return float(np.exp(np.log(self.noises).mean()))

    @cached_property
    def problem(self) -> RigProblem:
        cameras, held = [each.camera for each in self.alone], [each.is_held for each in self.alone]
        weights = [self.noise / float(noise) for noise in self.noises] if self.robust else None
        return RigProblem.of([each.views for each in self.located], cameras, held, weights)

    @cached_property
    def mask(self) -> Mask:
        """Points (m, n) of views that their own camera explains."""
        return self._without(self.problem.obs.mask, self._refused_alone())

    def _without(self, mask: Mask, views: Mapping[tuple[int, int], str]) -> Mask:
        left = mask.copy()
        for view, row, slots in self._views():
            if view in views:
                left[row, slots] = False
        return left

    def _views(self) -> Iterator[tuple[tuple[int, int], int, slice]]:
        """Views (moment, position) of the linked moments, their rows and columns."""
        for row, m in enumerate(self.linked):
            for i in self.given[m]:
                yield (m, i), row, self.problem.members[i].slots

    def run(self) -> RigCalibration:
        problem = self.problem
        motions = np.array([each.vector() for each in self.motions])
        k = problem.pack([each.camera.intrinsics for each in self.alone], motions)
        state = problem.at(k, Poses(*stack([each.board for each in self.located])))
        if not self.robust:
            return self._result(problem.solve(state, self.mask, Options()), self.mask)
        state, good = self._begin(state)
        among = self.mask
        for _ in range(len(self.linked) // MIN_MOMENTS_PER_LATE_VIEW):
            if not self._is_contradictory(state, good):
                break
            outcome = self._without_contradicting_view(state, among)
            if outcome is None:
                break
            among = outcome[1]
            state, good = self._least_squares(*outcome, among)
        lost = self._find_unlinked(good)
        if lost:
            raise CalibrationError(
                "unlinked", f"what camera {lost[0]} saw contradicts the others: too few moments are left"
            )
        return self._shaped(state, good) or self._result(state, good)

    def _shaped(self, state: State, good: Mask) -> RigCalibration | None:
        """Result with the board's shape; None if it explains no more than chance and motion do."""
        if not (self.board_shape and state.converged and good.any(axis=1).sum() >= MIN_SHAPE_VIEWS):
            return None
        noise2 = self._sigma(state, good) ** 2
        begun = MixedFit.begin(self.problem, state, good, self._labels(state, good), noise2)
        if begun is None:
            return None
        mixed = begun[0]
        shaped = mixed.solve(begun[1], good)
        if not (shaped.converged and mixed.problem.shape(shaped).is_plausible):
            return None
        return self._result(shaped, good, mixed)

    def _begin(self, state: State) -> tuple[State, Mask]:
        """Fit with all views, and if some contradict, with those near the start first.

        A compromise of moments that contradict each other may be far from all of them.
        """
        problem, near = self.problem, self._near_start(state)
        begun: list[tuple[bool, int, State, Mask]] = []
        for first in (self.mask,) if near is self.mask else (self.mask, near):
            moved = problem.solve(state, first, TOWARDS_OPTIMUM)
            fitted, good = self._least_squares(moved, self.mask, first)
            believed = fitted.converged and not self._is_contradictory(fitted, good)
            is_linked = not self._find_unlinked(good)
            begun.append((believed and is_linked, int(good.sum()), fitted, good))
            if believed and np.array_equal(good, self.mask):
                break
        _, _, state, good = max(begun, key=lambda each: each[:2])
        return state, good

    def _near_start(self, state: State) -> Mask:
        """Points (m, n) whose views agree with the start; all if without the others cameras are unlinked."""
        mask, visible = self.mask, self.problem.seen_by(self.mask)
        errors = np.full(visible.shape, np.nan)
        for i, member in enumerate(self.problem.members):
            square = medians(state.square[:, member.slots], mask[:, member.slots])
            errors[visible[:, i], i] = np.sqrt(square[visible[:, i]]) / (member.weight * member.img_size[0])
        shared = np.isfinite(errors).sum(axis=1) > 1
        if not shared.any():
            return mask
        typical = float(np.median(np.nanmax(errors[shared], axis=1)))
        far = errors > max(MAX_START_MEDIANS * typical, MIN_START_ERROR_WIDTHS)
        if not far.any():
            return mask
        left = mask.copy()
        for i, member in enumerate(self.problem.members):
            left[far[:, i], member.slots] = False
        return mask if self._find_unlinked(left) else left

    def _is_contradictory(self, state: State, good: Mask) -> bool:
        joint = float(np.sqrt(np.mean(state.square[good]) / 2))
        return joint > MAX_JOINT_NOISE_RATIO * max(self.noise, NOISE_FLOOR * self.problem.width)

    def _without_contradicting_view(self, state: State, among: Mask) -> tuple[State, Mask] | None:
        """Leave out the view that explains most of the noise of points `among` (m, n); None if no view does.

        Returns the state near the optimum, and the points left.
        """
        noise = float(np.sqrt(np.mean(state.square[among])))
        candidates: list[tuple[float, State, Mask]] = []
        for row, slots in self._candidates(state, among):
            left = among.copy()
            left[row, slots] = False
            if self._find_unlinked(left):
                continue
            moved = self.problem.solve(state, left, TOWARDS_OPTIMUM)
            if moved.is_finite:
                candidates.append((float(np.sqrt(np.mean(moved.square[left]))), moved, left))
        if not candidates:
            return None
        least, moved, left = min(candidates, key=lambda each: each[0])
        return (moved, left) if least < MIN_NOISE_DROP * noise else None

    def _find_unlinked(self, good: Mask) -> tuple[int, ...]:
        moments = [np.flatnonzero(seen).tolist() for seen in self.problem.seen_by(good)]
        return unlinked_cameras(len(self.alone), moments)

    def _candidates(self, state: State, among: Mask) -> list[tuple[int, slice]]:
        errors = []
        for row in range(len(among)):
            views = [member.slots for member in self.problem.members if among[row, member.slots].any()]
            if len(views) > 1:
                # of two views either may be the late one: which of them is left out is all the same
                errors += [
                    (float(np.mean(state.square[row, slots][among[row, slots]])), row, slots)
                    for slots in views[len(views) == 2 :]
                ]
        errors.sort(key=lambda each: -each[0])
        return [(row, slots) for _, row, slots in errors[:MAX_CANDIDATES]]

    def _least_squares(self, state: State, among: Mask, first: Mask) -> tuple[State, Mask]:
        """State and inliers `among` points (m, n); those of `first` show how much noise there is at first."""
        inliers = self._inliers(state, among, first, outliers.GROSS_OUTLIER_SIGMAS)
        state, good = self._reject_outliers(state, among, inliers)
        if state.converged and good.any() and not np.array_equal(inliers, good):
            tails = self.problem.solve(state, inliers, Options())
            ratio = np.mean(tails.square[inliers]) / np.mean(state.square[good])
            if ratio < MAX_TAIL_RMS_RATIO**2:
                return tails, inliers
        return state, good

    def _inliers(self, state: State, mask: Mask, among: Mask, sigmas: float) -> Mask:
        """Inlier mask (m, n) of the points of `mask`; the noise is that of those `among` them.

        A view most of whose points lie beyond so many `sigmas` is left out whole. Single points of other
        views are left out only from MIN_OUTLIER_WIDTHS on: detectors' errors have tails, and they hardly
        move a rig.
        """
        near = outliers.near_points(state, mask, among, sigmas, self.problem.width)
        if near is mask:
            return near
        good = near | (mask & (state.square < (MIN_OUTLIER_WIDTHS * self.problem.width) ** 2))
        for member in self.problem.members:
            counts = near[:, member.slots].sum(axis=1)
            there = mask[:, member.slots].sum(axis=1)
            enough = counts >= np.maximum(MIN_POINTS, outliers.MIN_INLIER_SHARE * there)
            good[:, member.slots] &= enough[:, None]
        return good

    def _reject_outliers(self, state: State, mask: Mask, inliers: Mask) -> tuple[State, Mask]:
        good, unsettled = inliers, 0
        for _ in range(MAX_REJECTIONS):
            if self._find_unlinked(good):
                return state, good  # refused later
            state = self.problem.solve(state, good, ROUND)
            previous, good = good, self._inliers(state, mask, good, outliers.OUTLIER_SIGMAS)
            unsettled += not state.converged
            if unsettled == MAX_UNSETTLED_ROUNDS:
                break
            if state.converged and np.array_equal(previous, good):
                return state, good
        return state, previous

    def _sigma(self, state: State, good: Mask) -> float:
        """Noise of one coordinate, px, corrected for the degrees of freedom."""
        used = 2 * float(good.sum())
        unknowns = self.problem.size + 6 * float(good.any(axis=1).sum())
        sigma = float(np.sqrt(state.square[good].sum() / max(used - unknowns, 0.1 * used, 1.0)))
        return max(sigma, levenberg_marquardt.ROUNDOFF * self.problem.width)

    def _labels(self, state: State, good: Mask) -> IntArray:
        image = self.problem.members[0]
        focal = float(image.model.focal(self.problem.intrinsics(state.k, 0))[0]) / image.img_size[0]
        return robust_covariance.same_pose_labels(state.poses, self.problem.obs, good, focal)

    def _result(self, optimum: State, good: Mask, mixed: MixedFit | None = None) -> RigCalibration:
        """Result at the optimum; `mixed`: how the board's shape was fitted."""
        if not optimum.converged:
            raise CalibrationError(
                "not_converged", "the fit did not settle: the moments contradict each other"
            )
        problem, state, shape = self.problem, optimum, None
        if mixed:
            bent = mixed.problem.reshaped(optimum.k[:SHAPE_SIZE], problem.obs)
            problem, state = replace(problem, obs=bent), mixed.problem.of_camera(optimum)
        obs = problem.obs
        cameras = tuple(problem.camera(state.k, i) for i in range(len(self.alone)))
        self._check_domain(cameras, state, good)
        sigma = self._sigma(state, good)
        poses = problem.camera_poses(state.k)
        taken = np.flatnonzero(good.any(axis=1))
        rows, counted = state.rows[:, :, taken], good[taken]
        distances = transfer.working_distances(problem, state, good)
        jacobian = transfer.jacobian(problem, state.k, distances)
        metric = transfer.metric(jacobian, rows, counted)
        if mixed:
            spread = mixed.spread(optimum, good, sigma, good, metric)
            covariance = spread.covariance[SHAPE_SIZE:, SHAPE_SIZE:]
            shape = mixed.problem.shape(optimum)
            shape = replace(shape, covariance=frozen(spread.covariance[:SHAPE_SIZE, :SHAPE_SIZE]))
        else:
            boards = Poses(state.poses.r[taken], state.poses.t[taken])
            by_pose, points = rows[problem.size : -1], obs.points[taken]
            effects = systematic_effects.displacements(by_pose, boards, points, problem.row_positions[taken])
            labels = self._labels(state, good)[taken]
            evidence = robust_covariance.Evidence.of(rows, effects, boards, labels, metric, counted)
            believed = problem.prior_information(state.k) * max(sigma, 1e-5 * problem.width) ** 2
            spread = robust_covariance.estimate(evidence, sigma, believed)
            covariance = spread.covariance
        if not np.isfinite(spread.covariance).all():
            raise CalibrationError("not_believable", "the fit has no finite error")
        square = np.where(obs.mask, state.square, 0.0)
        for member in problem.members:
            square[:, member.slots] /= member.weight**2
        errors = {}
        for view, row, slots in self._views():
            errors[view] = float(np.sqrt(square[row, slots].sum() / obs.mask[row, slots].sum()))
        aside = self._set_aside(good)
        left = self._without(obs.mask & np.isfinite(square), aside)
        board_poses = np.full((len(self.given), 6), np.nan)
        board_poses[list(self.linked)] = np.concatenate([vector(state.poses.r), state.poses.t], axis=1)
        return RigCalibration(
            cameras=cameras,
            poses=frozen(poses),
            board_poses=frozen(board_poses),
            rms=float(np.sqrt(square[left].sum() / max(left.sum(), 1))),
            view_errors=errors,
            covariance=frozen(self._all_intrinsics(covariance)),
            noise=sigma,
            inflation=spread.inflation,
            uncertainty=transfer.uncertainty(problem, state.k, jacobian, covariance, distances),
            working_distances=frozen(distances),
            set_aside=aside,
            turned=tuple(
                (m, i) for m, each in zip(self.linked, self.located, strict=True) for i in each.turned
            ),
            board_shape=shape,
        )

    def _check_domain(self, cameras: Sequence[Camera], state: State, good: Mask) -> None:
        points = self.problem.points_before_cameras(state.k, state.poses, self.problem.obs)
        for i, p in enumerate(points):
            inside = cameras[i].valid(p.transpose(0, 2, 1))[good[:, self.problem.members[i].slots]]
            if inside.size and np.mean(~inside) > plausibility.MAX_SHARE_OUTSIDE_DOMAIN:
                raise CalibrationError("not_believable", f"camera {i}: its points lie where the model folds")

    def _refused_alone(self) -> dict[tuple[int, int], str]:
        return {(m, i): why for i, each in enumerate(self.alone) for m, why in each.reasons.items()}

    def _set_aside(self, good: Mask) -> dict[tuple[int, int], str]:
        reasons = self._refused_alone()
        for view, row, slots in self._views():
            if not good[row, slots].any():
                reasons.setdefault(view, "contradicts")
        return reasons

    def _all_intrinsics(self, covariance: Array) -> Array:
        """Covariance (q, q) with rows and columns of 0 for intrinsics that are held."""
        held = [np.full(member.model.size, member.held is not None) for member in self.problem.members]
        free = np.flatnonzero(~np.concatenate([*held, np.zeros(6 * (len(held) - 1), dtype=bool)]))
        out = np.zeros((sum(map(len, held)) + 6 * (len(held) - 1),) * 2)
        out[np.ix_(free, free)] = covariance
        return out


FOLDS = 5


@undetermined()
def held_out_rms(moments: Sequence[Moment], calibration: RigCalibration) -> float | None:
    """px, rms over all points of the moments left out, whose board poses are fitted.

    Views that the fit set aside stay out. None if no part can be left out without unlinking cameras.
    """
    used = [
        {i: view for i, view in moment.items() if (m, i) not in calibration.set_aside}
        for m, moment in enumerate(moments)
    ]
    used = [moment for moment in used if moment]
    # Intrinsics without variance were held.
    cameras: list[Specification] = [
        (camera.img_size, camera.model) if calibration.intrinsics_covariance(i).any() else camera
        for i, camera in enumerate(calibration.cameras)
    ]
    squares, points = 0.0, 0
    for fold in range(min(FOLDS, len(used))):
        training = [moment for m, moment in enumerate(used) if m % FOLDS != fold]
        try:
            starts, bends = dict(enumerate(calibration.cameras)), calibration.board_shape is not None
            rig = fit(training, cameras, starts=starts, board_shape=bends)
        except CalibrationError:
            continue  # nothing is left that links the cameras, or too little of one of them
        square, count = _score(rig, rig.shaped(used[fold::FOLDS]))
        squares, points = squares + square, points + count
    return float(np.sqrt(squares / points)) if points else None


class _HeldRig(RigProblem):
    """Rig of which only the board's poses are fitted."""

    def at(self, k: Array, poses: Poses) -> State:
        state = super().at(k, poses)
        return replace(state, rows=state.rows[self.size :], prior_jacobian=state.prior_jacobian[:, :0])

    def free(self, da: Array) -> Array:
        return np.zeros((self.size, len(da))) @ da  # no direction is free


def _score(rig: RigCalibration, moments: Sequence[Moment]) -> tuple[float, int]:
    """Sum of the squared distances, px^2, over moments whose board poses are fitted, and number of points."""
    alone = {
        i: fit_alone(moments, i, camera, True, None)
        for i, camera in enumerate(rig.cameras)
        if any(i in moment for moment in moments)
    }
    usable = [moment for moment in resected(moments, alone) if moment.poses]
    turns = symmetries([view for moment in moments for view in moment.values()])
    located = locate_boards(rig.cameras, rig.motions, usable, turns)
    if not located:
        return 0.0, 0
    problem = _HeldRig.of([each.views for each in located], rig.cameras, [True] * len(rig.cameras))
    poses = Poses(*stack([each.board for each in located]))
    k = problem.pack([camera.intrinsics for camera in rig.cameras], rig.poses)
    with np.errstate(all="ignore"):
        state = problem.solve(problem.at(k, poses), problem.obs.mask.astype(float), Options(with_prior=False))
    mask = problem.obs.mask & np.isfinite(state.square)
    return float(state.square[mask].sum()), int(mask.sum())
