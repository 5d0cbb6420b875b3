"""Views that contradict a rig although no residual of a joint fit stands out.

A board that moved between the images of two cameras makes a moment whose views are right, but not
together. A fit to few moments bends to it. But then the rig has far more noise than its single cameras,
and without that view it has not. So views are left out one at a time.
"""

import numpy as np

from ..arrays import Mask
from ..fitting import outliers
from ..fitting.levenberg_marquardt import NOISE_FLOOR, State
from ..fitting.multistart import TOWARDS_OPTIMUM
from ..fitting.robust_homography import medians
from .problem import RigProblem, unlinked_cameras

MAX_JOINT_NOISE_RATIO = 1.5
"""Noise of the rig / noise of its single cameras, from which a contradicting view is searched."""
MIN_NOISE_DROP = 0.6
"""Noise of the rig without a view / with it, below which the view is set aside."""
MAX_START_MEDIANS = 3.0
"""Error of a moment under the start / that of the typical moment, up to which its views agree at first."""
MIN_START_ERROR_WIDTHS = 1e-3
"""Error under the start / image width below which a view agrees."""
MAX_CANDIDATES = 12


def near_start(problem: RigProblem, state: State, mask: Mask) -> Mask:
    """Points (m, n) of `mask` whose views agree with the start; all of `mask` if others would unlink cameras.

    A compromise of moments that contradict each other may be far from all of them, so a fit begins with
    these.
    """
    errors = np.full((len(mask), len(problem.members)), np.nan)
    for i, member in enumerate(problem.members):
        there = mask[:, member.slots]
        visible = there.any(axis=1)
        square = medians(state.square[:, member.slots], there)
        errors[visible, i] = np.sqrt(square[visible]) / (member.weight * member.img_size[0])
    shared = np.isfinite(errors).sum(axis=1) > 1
    if not shared.any():
        return mask
    typical = float(np.median(np.nanmax(errors[shared], axis=1)))
    far = errors > max(MAX_START_MEDIANS * typical, MIN_START_ERROR_WIDTHS)
    if not far.any():
        return mask
    left = mask.copy()
    for i, member in enumerate(problem.members):
        left[far[:, i], member.slots] = False
    return mask if find_unlinked(problem, left) else left


def is_contradictory(problem: RigProblem, state: State, good: Mask, noise: float) -> bool:
    """True if points `good` (m, n) are noisier in the rig than in its single cameras (`noise`, px)."""
    joint = float(np.sqrt(np.mean(state.square[good]) / 2))
    return joint > MAX_JOINT_NOISE_RATIO * max(noise, NOISE_FLOOR * problem.width)


def without_contradicting_view(problem: RigProblem, state: State, among: Mask) -> tuple[State, Mask] | None:
    """Leave out the view that explains most of the noise of points `among` (m, n); None if no view does.

    Returns the state near the optimum, and the points left.
    """
    noise = float(np.sqrt(np.mean(state.square[among])))
    candidates: list[tuple[float, State, Mask]] = []
    for row, slots in _candidates(problem, state, among):
        left = among.copy()
        left[row, slots] = False
        if find_unlinked(problem, left):
            continue
        moved = problem.solve(state, outliers.unit_weights(left), TOWARDS_OPTIMUM)
        if moved.is_finite:
            candidates.append((float(np.sqrt(np.mean(moved.square[left]))), moved, left))
    if not candidates:
        return None
    least, moved, left = min(candidates, key=lambda each: each[0])
    return (moved, left) if least < MIN_NOISE_DROP * noise else None


def find_unlinked(problem: RigProblem, good: Mask) -> tuple[int, ...]:
    """Positions that no chain of moments links to camera 0, of points `good` (m, n)."""
    visible = np.stack([good[:, member.slots].any(axis=1) for member in problem.members], axis=1)
    return unlinked_cameras(len(problem.members), [np.flatnonzero(moment).tolist() for moment in visible])


def _candidates(problem: RigProblem, state: State, among: Mask) -> list[tuple[int, slice]]:
    errors = []
    for row in range(len(among)):
        views = [member.slots for member in problem.members if among[row, member.slots].any()]
        if len(views) > 1:
            # of two views either may be the late one: which of them is left out is all the same
            errors += [
                (float(np.mean(state.square[row, slots][among[row, slots]])), row, slots)
                for slots in views[len(views) == 2 :]
            ]
    errors.sort(key=lambda each: -each[0])
    return [(row, slots) for _, row, slots in errors[:MAX_CANDIDATES]]
