"""The error of a rig on moments that took no part in its fit: what it is worth elsewhere."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError, undetermined
from ..fitting.levenberg_marquardt import Options, State
from ..fitting.normal_equations import Poses
from ..models import get
from . import start
from .calibration import RigCalibration
from .fit import fit
from .problem import Moment, RigMember, RigProblem, pack_moments
from .single import Specification, fit_alone
from .start import ResectedMoment, RigidMotion

FOLDS = 5
"""Parts of a cross-validation: moment m is in part m mod FOLDS."""


@undetermined()
def held_out_rms(moments: Sequence[Moment], calibration: RigCalibration) -> float | None:
    """Cross-validate a rig: cameras and relative poses from the other moments, board poses fitted.

    Parameters
    ----------
    moments
        Moments of the fit. Views that the fit set aside stay out.
    calibration
        The fit to all of them. What it held is held; what it found is where the parts begin.

    Returns
    -------
    px, root of the mean square distance over all points of the moments left out; None if no part can be
    left out without cutting the cameras' links.
    """
    used = [
        {i: view for i, view in moment.items() if (m, i) not in calibration.set_aside}
        for m, moment in enumerate(moments)
    ]
    used = [moment for moment in used if moment]
    cameras = [_specification(calibration, i) for i in range(len(calibration.cameras))]
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
    """Rig of which everything is known: only the board's poses are fitted."""

    def at(self, k: Array, poses: Poses) -> State:
        state = super().at(k, poses)
        return replace(state, rows=state.rows[self.size :], prior_jacobian=state.prior_jacobian[:, :0])

    def free(self, da: Array) -> Array:
        return np.zeros((self.size, len(da))) @ da  # no direction is free


def _specification(calibration: RigCalibration, position: int) -> Specification:
    """Describe a camera as `fit` had it: intrinsics without variance were held."""
    sizes = [len(camera.intrinsics) for camera in calibration.cameras]
    first = sum(sizes[:position])
    camera: Camera = calibration.cameras[position]
    variance = np.diagonal(calibration.covariance)[first : first + sizes[position]]
    return (camera.img_size, camera.model) if variance.any() else camera


def _score(rig: RigCalibration, moments: Sequence[Moment]) -> tuple[float, int]:
    """Sum squared distances, px^2, over moments whose board poses are fitted, and count the points."""
    motions = tuple(RigidMotion.of_vector(pose) for pose in rig.poses)
    alone = {
        i: fit_alone(moments, i, camera, True, None)
        for i, camera in enumerate(rig.cameras)
        if any(i in moment for moment in moments)
    }
    usable = [
        ResectedMoment(moment, {i: alone[i].poses[m] for i in moment if m in alone[i].poses})
        for m, moment in enumerate(moments)
    ]
    turns = start.symmetries([view for moment in moments for view in moment.values()])
    settled = start.locate_boards(rig.cameras, motions, [moment for moment in usable if moment.poses], turns)
    if not settled:
        return 0.0, 0
    boards, views = [each.board for each in settled], [each.views for each in settled]
    lengths = [
        max((len(moment[i]) for moment in views if i in moment), default=0) for i in range(len(motions))
    ]
    starts = np.cumsum([0, *lengths]).tolist()
    members = tuple(
        RigMember(get(camera.model), camera.img_size, camera.intrinsics, slice(starts[i], starts[i + 1]))
        for i, camera in enumerate(rig.cameras)
    )
    problem = _HeldRig(members, pack_moments(views, lengths))
    poses = Poses(np.array([board.r for board in boards]), np.array([board.t for board in boards]))
    k = problem.pack([camera.intrinsics for camera in rig.cameras], rig.poses)
    with np.errstate(all="ignore"):
        state = problem.solve(problem.at(k, poses), problem.obs.mask.astype(float), Options(with_prior=False))
    mask = problem.obs.mask & np.isfinite(state.square)
    return float(state.square[mask].sum()), int(mask.sum())
