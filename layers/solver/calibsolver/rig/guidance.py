"""Guidance of a rig: the moment after which its predicted error is least.

The search is as in `guidance.search`. Poses are drawn in front of each camera in turn, and scored by all
cameras that would see enough of the board: a pose that several cameras see usually wins, or a close-up for
one camera whose lens is known least. Information is divided by the rig's inflation, as if the errors of
hands and boards were as large as in the moments so far.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import Array, IntArray, Mask, frozen, symmetric_inverse
from ..board import Board
from ..camera import Camera
from ..errors import CalibrationError, undetermined
from ..fitting import normal_equations
from ..fitting.normal_equations import Poses
from ..fitting.observations import Observations
from ..guidance import candidates
from ..guidance.candidates import CornerGrid, PoseLimits, RayGrid
from ..guidance.posterior import MIN_NOISE_WIDTHS, IntrinsicsPosterior
from ..guidance.projection_uncertainty import ProjectionUncertainty
from ..guidance.search import is_similar
from ..guidance.target import TargetPose
from ..view import View
from . import transfer
from .calibration import RigCalibration
from .problem import Moment, RigProblem, unlinked_cameras
from .start import RigidMotion, Specification

LIMITS = PoseLimits(width=(0.14, 1.1), max_tilt_deg=50.0, max_roll_deg=40.0, min_visible=0.5)
"""For the camera that leads: a board that two cameras see may have to be far away."""
OTHER_LIMITS = replace(LIMITS, min_visible=0.3, max_incidence_deg=72.0)
"""For the others: beyond, their views are not counted on."""
SAMPLES = 96
MAX_LEADERS = 4
"""Cameras that lead for one target: the others have their turn with the next."""
ELITE_COUNT, NEAR_SAMPLES = 4, 12
RIG_SEARCH_RADII = (0.25, 0.15, 0.08)
LINKING = ((0.5, 0.35), (0.8, 0.3), (0.2, 0.3), (0.5, 0.2), (0.85, 0.2), (0.15, 0.2))
"""Targets that are to link cameras: place / image width, length of the board / image."""
EQUAL_ERROR_RATIO = 1.03
"""Error / least error within which poses count as equally good: the most cameras decide."""


@dataclass(frozen=True, eq=False)
class RigTarget:
    """Moment to be captured.

    Attributes
    ----------
    pose
        (6,) rvec|tvec, board -> camera 0; None if the rig is not known yet.
    views
        The target by position, as each camera that would see the board would see it.
    unlinked
        Positions that no chain of moments links to camera 0.
    """

    pose: Array | None
    views: Mapping[int, TargetPose]
    purpose: str
    unlinked: tuple[int, ...] = ()


@undetermined()
def next_moment(
    board: Board,
    cameras: Sequence[Specification],
    moments: Sequence[Moment],
    calibration: RigCalibration | None,
    skipped: Sequence[Array] = (),
    missed: int = 0,
) -> RigTarget:
    """Choose the next moment.

    Parameters
    ----------
    cameras
        As for `fit`.
    calibration
        The fit to the `moments`, or None.
    skipped
        (6,) poses, board -> camera 0, that the user could not reach: others are chosen.
    missed
        Targets given up since the last moment while cameras were still to be linked.
    """
    lost = unlinked_cameras(len(cameras), moments)
    if calibration is None or lost:
        return _link(board, cameras, moments, lost, missed)
    with np.errstate(all="ignore"):
        pose = _Search(board, cameras, calibration, skipped).best(len(moments))
    if pose is None:
        return _link(board, cameras, moments, lost, missed)
    views = {}
    purpose = "to join the cameras"
    for i, motion in enumerate(calibration.motions):
        seen = motion @ pose
        target = TargetPose.seen(board, calibration.cameras[i], seen.r, seen.t, purpose, 0.0)
        if target.ids:
            views[i] = target
    return RigTarget(frozen(pose.vector()), views, purpose)


def _link(
    board: Board,
    cameras: Sequence[Specification],
    moments: Sequence[Moment],
    lost: Sequence[int],
    missed: int,
) -> RigTarget:
    """Target wholly visible to one camera; another should see the board at the same time.

    The place of that camera is unknown, so each attempt is elsewhere.
    """
    lead = lost[0] if lost and any(lost[0] in moment for moment in moments) else 0
    given = cameras[lead]
    size, model = (given.img_size, given.model) if isinstance(given, Camera) else given
    seed = given if isinstance(given, Camera) else None
    posterior = IntrinsicsPosterior.of(model, size, None, seed)
    attempt = missed + sum(lead in moment for moment in moments)
    if not attempt:
        target = ProjectionUncertainty(board, size, model, seed).first_pose(posterior)
    else:
        x, width = LINKING[(attempt - 1) % len(LINKING)]
        limits = PoseLimits(width=(width, width), max_tilt_deg=20.0, max_roll_deg=0.0)
        unit = np.array([[x, 0.5, 0.5, 0.5, 0.25 * attempt % 1.0, 0.5]])
        pose = candidates.poses_from_unit_cube(unit, board, posterior.rays, limits)
        target = TargetPose.seen(board, posterior.camera, pose.r[0], pose.t[0], "", 0.0)
    purpose = f"to link camera {lost[0]}" if lost else "a first look"
    return RigTarget(None, {lead: replace(target, purpose=purpose)}, purpose, tuple(lost))


class _Search:
    """Search for the pose of the board after which the error of transfer is least."""

    def __init__(
        self,
        board: Board,
        cameras: Sequence[Specification],
        calibration: RigCalibration,
        skipped: Sequence[Array],
    ) -> None:
        self.board = board
        self.cameras = calibration.cameras
        self.motions = calibration.motions
        self.corners = CornerGrid.of(board, 5)
        self.skipped = [RigidMotion.of_vector(np.asarray(pose)) for pose in skipped]
        # The pixels do not matter: only the points are used.
        grid = View(self.corners.points.T, self.corners.points[:2].T)
        held = [isinstance(each, Camera) for each in cameras]
        self.problem = problem = RigProblem.of([dict.fromkeys(range(len(cameras)), grid)], self.cameras, held)
        self.k = problem.pack([camera.intrinsics for camera in self.cameras], calibration.poses)
        free = np.flatnonzero(np.diagonal(calibration.covariance) > 0)
        if len(free) != problem.size:
            raise CalibrationError("bad_rig", "the calibration is not one of these cameras")
        self.noise2 = max(calibration.noise, MIN_NOISE_WIDTHS * problem.width) ** 2 * calibration.inflation
        self.information = symmetric_inverse(calibration.covariance[np.ix_(free, free)])
        jacobian = transfer.jacobian(problem, self.k, np.asarray(calibration.working_distances))
        flat = jacobian.reshape(-1, problem.size)
        self.metric = flat.T @ flat / max(len(jacobian), 1)
        self.rays = [RayGrid.of(camera) for camera in self.cameras]

    def best(self, index: int) -> RigidMotion | None:
        """Best pose, board -> camera 0, or None."""
        count = len(self.cameras)
        leaders = [(index + i) % count for i in range(min(count, MAX_LEADERS))]
        unit = np.concatenate([candidates.r_sequence(SAMPLES, index)] * len(leaders))
        lead = np.repeat(leaders, SAMPLES)
        error, sharing = self._errors(unit, lead)
        offsets = candidates.r_sequence(ELITE_COUNT * NEAR_SAMPLES, 1) - 0.5
        for radius in RIG_SEARCH_RADII:
            elite = np.argsort(error)[:ELITE_COUNT]
            if not np.isfinite(error[elite[0]]):
                return None
            near = np.repeat(unit[elite], NEAR_SAMPLES, axis=0) + 2 * radius * offsets
            near[:, 4] %= 1.0
            near, near_lead = np.clip(near, 0.0, 1.0), np.repeat(lead[elite], NEAR_SAMPLES)
            near_error, near_sharing = self._errors(near, near_lead)
            unit, lead = np.concatenate([unit, near]), np.concatenate([lead, near_lead])
            error, sharing = np.concatenate([error, near_error]), np.concatenate([sharing, near_sharing])
        ties = np.flatnonzero(error <= EQUAL_ERROR_RATIO * error.min())
        chosen = ties[np.lexsort((error[ties], -sharing[ties]))[0]]
        poses = self._poses(unit[chosen : chosen + 1], lead[chosen : chosen + 1])
        return RigidMotion(poses.r[0], poses.t[0])

    def _poses(self, unit: Array, lead: IntArray) -> Poses:
        """Poses, board -> camera 0, of points (c, 6) of the unit cube in front of cameras `lead` (c,)."""
        r, t = np.empty((len(unit), 3, 3)), np.empty((len(unit), 3))
        for i in np.unique(lead).tolist():
            rows = np.flatnonzero(lead == i)
            there = candidates.poses_from_unit_cube(unit[rows], self.board, self.rays[i], LIMITS)
            back = self.motions[i].inverse()
            r[rows], t[rows] = back.r @ there.r, there.t @ back.r.T + back.t
        return Poses(r, t)

    def _errors(self, unit: Array, lead: IntArray) -> tuple[Array, IntArray]:
        """Mean square error of transfer (c,), px^2, after candidates, and how many cameras see them (c,)."""
        poses = self._poses(unit, lead)
        visible, seen = self._visibility(poses, lead)
        sharing = seen.sum(axis=1)
        feasible = seen[np.arange(len(lead)), lead]
        for each in self.skipped:
            feasible &= ~is_similar(poses, each.r, each.t, self.board)
        use = np.flatnonzero(feasible)
        error = np.full(len(unit), np.inf)
        if use.size:
            points = np.tile(self.problem.obs.points, (len(use), 1, 1))
            obs = Observations(points, np.zeros_like(points[:, :2]), visible[use])
            state = replace(self.problem, obs=obs).at(self.k, Poses(poses.r[use], poses.t[use]))
            rows = state.rows[:-1] * np.sqrt(self.corners.multiplicity)
            s = normal_equations.schur_complement(normal_equations.gram_matrices(rows))
            after = symmetric_inverse(self.information + s / self.noise2)
            error[use] = np.einsum("cij,ij->c", after, self.metric)
            error[~np.isfinite(error)] = np.inf
        return error, sharing

    def _visibility(self, poses: Poses, lead: IntArray) -> tuple[Mask, Mask]:
        """Corners (c, n) that count, in all cameras' slots, and cameras (c, k) that see candidates."""
        visible = np.zeros((len(lead), self.problem.obs.mask.shape[1]), dtype=bool)
        seen = np.zeros((len(lead), len(self.cameras)), dtype=bool)
        for i, (camera, motion) in enumerate(zip(self.cameras, self.motions, strict=True)):
            there = Poses(motion.r @ poses.r, poses.t @ motion.r.T + motion.t)
            p = there.camera_points(self.corners.points)
            member = self.problem.members[i]
            q = member.model.project(camera.intrinsics, p.transpose(1, 0, 2)).transpose(1, 0, 2)
            found, within = candidates.check_visibility(p, q, there.r, self.corners, camera, OTHER_LIMITS)
            _, as_leader = candidates.check_visibility(p, q, there.r, self.corners, camera, LIMITS)
            within = np.where(lead == i, as_leader, within)
            within &= candidates.is_in_front(there, self.board, self.rays[i])
            seen[:, i] = within
            visible[:, member.slots] = (found == 1) & within[:, None]
        return visible, seen
