"""Search for the next-best view: the candidate pose after which the projection error is least."""

from dataclasses import dataclass

import numpy as np

from ..arrays import Array, IntArray, Mask, whitening
from ..board import Board
from ..fitting.normal_equations import Poses
from . import candidates
from .candidates import CornerGrid, PoseLimits
from .pose_history import PoseHistory
from .posterior import IntrinsicsPosterior
from .target import TargetPose

SEARCH_COLUMNS = 8
"""Most columns of corners with which candidates are evaluated: those of the default board."""
CANDIDATE_COUNT = 128
ELITE_COUNT, SAMPLES_PER_ELITE = 4, 16
"""Candidates that are refined in a round, and samples around each."""
SEARCH_RADII = (0.3, 0.2, 0.14, 0.09, 0.05)
REFINEMENT_RADII = (0.2, 0.12, 0.06)
"""Radii around the elite, / a candidate's range: in a new search, and among earlier candidates."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Evaluated candidates (c, 6) and their Fisher information (c, p, p), whitened."""

    unit: Array
    information: Array

    def concat(self, other: "Candidates") -> "Candidates":
        """Both sets of candidates."""
        return Candidates(
            np.concatenate([self.unit, other.unit]), np.concatenate([self.information, other.information])
        )

    def take(self, index: IntArray) -> "Candidates":
        """Candidates at some indices."""
        return Candidates(self.unit[index], self.information[index])


class Search:
    """Cross-entropy method: wide sampling, then ever closer samples around the best candidates (the elite).

    Information is whitened by the posterior's, so that nothing is badly scaled: with A the posterior's
    information, T'AT = 1 and S a candidate's, trace((A + S)^-1 W) = trace((1 + T'ST)^-1 T'WT). Candidates
    must not resemble `skipped` targets.
    """

    def __init__(
        self,
        board: Board,
        posterior: IntrinsicsPosterior,
        limits: PoseLimits,
        skipped: tuple[TargetPose, ...] = (),
        history: PoseHistory | None = None,
    ) -> None:
        self.board = board
        self.posterior = posterior
        self.limits = limits
        self.skipped = skipped
        self.history = history
        self.corners = CornerGrid.of(board, SEARCH_COLUMNS)
        self._whiten = whitening(posterior.information).T
        self._metric = self._whiten @ posterior.error_metric @ self._whiten.T
        self._offsets = candidates.r_sequence(SAMPLES_PER_ELITE * ELITE_COUNT, 1) - 0.5

    def evaluate(self, unit: Array) -> Candidates:
        """Candidates (c, 6) within the limits."""
        posterior = self.posterior
        poses = candidates.poses_from_unit_cube(unit, self.board, posterior.rays, self.limits)
        s, feasible = fisher_information(posterior, poses, self.corners, self.limits)
        feasible &= candidates.is_in_front(poses, self.board, posterior.rays)
        for target in self.skipped:
            feasible &= ~is_similar(poses, target.r, target.tvec, self.board)
        use = np.flatnonzero(feasible)
        noise = np.full(use.size, posterior.noise)
        if self.history is not None:
            tilt, width = candidates.tilt_and_width_from_unit_cube(unit[use], self.limits)
            noise *= self.history.expected_noise(tilt, width)
        return Candidates(unit[use], self._whiten @ (s[use] / noise[:, None, None] ** 2) @ self._whiten.T)

    def score(self, information: Array, other: Array | None = None) -> Array:
        """Mean square projection error (c,) px^2 after candidates of information (c, p, p).

        `other` (p, p) is the information of another view that is added to each.
        """
        known = np.eye(len(self._metric)) if other is None else np.eye(len(self._metric)) + other
        return np.asarray(np.einsum("cij,ij->c", np.linalg.inv(known + information), self._metric))

    def refine(
        self, start: Candidates, radii: tuple[float, ...], other: Array | None = None
    ) -> tuple[Candidates, Candidates, Array]:
        """Search around the best candidates, given another view of information `other` (p, p).

        Returns all candidates, those of the last round, and the scores of the latter.
        """
        score = self.score(start.information, other)
        evaluated, last = start, start
        for radius in radii:
            if not last.unit.size:
                break
            elite = np.argsort(score)[:ELITE_COUNT]
            near = np.repeat(last.unit[elite], SAMPLES_PER_ELITE, axis=0)
            near = near + 2 * radius * self._offsets[: len(near)]
            near[:, 4] %= 1.0
            new = self.evaluate(np.clip(near, 0.0, 1.0))
            evaluated, last = evaluated.concat(new), last.take(elite).concat(new)
            score = np.concatenate([score[elite], self.score(new.information, other)])
        return evaluated, last, score

    def best(self, index: int, ahead: int) -> tuple[Array, Array] | None:
        """Best candidates (c, 6) for the next of `ahead` views, 1 or 2, and their scores (c,).

        The best single pose need not be one of the best two: the second is chosen to complement the first,
        then the first again to complement the second. The one that is better on its own comes first.
        """
        sample = candidates.r_sequence(CANDIDATE_COUNT, index + 7 * len(self.skipped))
        evaluated, last, score = self.refine(self.evaluate(sample), SEARCH_RADII)
        if not last.unit.size:
            return None
        if ahead < 2:
            return last.unit, score
        first = last.information[int(np.argmin(score))]
        evaluated, last, score = self.refine(evaluated, REFINEMENT_RADII, first)
        second_best, second_score = last.take(np.argsort(score)[:8]), float(score.min())
        second = second_best.information[0]
        _, last, score = self.refine(evaluated, REFINEMENT_RADII, second)
        first_best = last.take(np.argsort(score)[:8])
        if score.min() < second_score:
            first = first_best.information[0]
        alone = self.score(np.stack([first, second]))
        if alone[1] < alone[0]:
            return second_best.unit, self.score(second_best.information, first)
        return first_best.unit, self.score(first_best.information, second)


def fisher_information(
    posterior: IntrinsicsPosterior, poses: Poses, corners: CornerGrid, limits: PoseLimits
) -> tuple[Array, Mask]:
    """Fisher information (c, p, p) of the intrinsics from views at poses (c), at noise of 1 px.

    A corner counts by how probably it is found. Also returned is which poses (c,) respect the limits;
    others have 0.
    """
    p = poses.r @ corners.points + poses.t[:, :, None]
    q = posterior.model.project(posterior.k, p.transpose(1, 0, 2)).transpose(1, 0, 2)
    found, feasible = candidates.check_visibility(p, q, poses.r, corners, posterior.camera, limits)
    use = np.flatnonzero(feasible)
    s = np.zeros((len(feasible), posterior.model.size, posterior.model.size))
    if use.size:
        possible = Poses(poses.r[use], poses.t[use])
        s[use], _ = posterior.limited_information(possible, corners.points, found[use] * corners.multiplicity)
    return s, feasible


def is_similar(poses: Poses, r: Array, t: Array, board: Board) -> Mask:
    """True if poses (c) resemble one: normals within 20 degrees, centres within 1.5 squares."""
    center = board.outline.mean(axis=0)
    distance = np.linalg.norm(poses.r @ center + poses.t - (r @ center + t), axis=1)
    cos_angle = poses.r[:, :, 2] @ r[:, 2]
    return np.asarray((cos_angle > np.cos(np.radians(20))) & (distance < 1.5))
