"""Error of a rig on moments that took no part in its fit."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..errors import CalibrationError, undetermined
from ..fitting.levenberg_marquardt import Options, State
from ..fitting.normal_equations import Poses
from . import start
from .calibration import RigCalibration
from .fit import fit
from .problem import Moment, RigProblem
from .start import Specification, fit_alone, resected

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
    turns = start.symmetries([view for moment in moments for view in moment.values()])
    located = start.locate_boards(rig.cameras, rig.motions, usable, turns)
    if not located:
        return 0.0, 0
    problem = _HeldRig.of([each.views for each in located], rig.cameras, [True] * len(rig.cameras))
    poses = Poses(*start.stack([each.board for each in located]))
    k = problem.pack([camera.intrinsics for camera in rig.cameras], rig.poses)
    with np.errstate(all="ignore"):
        state = problem.solve(problem.at(k, poses), problem.obs.mask.astype(float), Options(with_prior=False))
    mask = problem.obs.mask & np.isfinite(state.square)
    return float(state.square[mask].sum()), int(mask.sum())
