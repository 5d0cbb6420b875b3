"""Search for the next-best view: the candidate pose after which the projection error is least."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import rotation
from ..arrays import Array, IntArray, Mask, whitening
from ..board import Board
from ..camera import Camera
from ..fitting.calibration import Calibration
from ..fitting.normal_equations import Poses
from . import candidates
from .candidates import CornerGrid, PoseLimits
from .hints import Placement
from .posterior import MIN_NOISE_WIDTHS, IntrinsicsPosterior
from .target import TargetPose

CLOSE_UP_WIDTH, STEEP_TILT_DEG = 0.75, 45.0
"""Apparent width / image, and tilt, from which fixed-focus lenses blur and glossy boards reflect."""
UNPROVEN_NOISE_FACTOR = 1.1
"""Noise expected beyond these, until a view has been there / noise of the best view."""
MIN_BAD_NOISE_FACTOR = 1.35
"""Noise of a view / noise of the best, from which poses like it are bad, not this one by chance."""
RETREAT = 0.8
"""Share of an unreached target's tilt or width that later targets may have."""
EASY_TILT_DEG, EASY_WIDTH = 25.0, 0.6


@dataclass(frozen=True, eq=False)
class PoseHistory:
    """Views of a session (v), and targets not reached (m).

    Attributes
    ----------
    tilt, width, noise
        (v,) degrees; apparent length of the board's longer side / the image's; noise / that of the best view.
    unreached
        (m, 2) tilt and width.
    """

    tilt: Array
    width: Array
    noise: Array
    unreached: Array

    @classmethod
    def of(
        cls,
        board: Board,
        camera: Camera,
        calibration: Calibration | None,
        unreached: Sequence[TargetPose],
    ) -> "PoseHistory":
        """History of a calibration's views and of targets given up, as `camera` sees them."""
        rt = np.empty((0, 6)) if calibration is None else calibration.poses
        given_up = np.array([[*t.rvec, *t.tvec] for t in unreached]).reshape(-1, 6)
        tilts_and_widths = []
        for pose in np.concatenate([rt, given_up]):
            placed = Placement.of(board, camera, rotation.matrix(pose[:3]), pose[3:])
            width = camera.focal[0] * max(board.size) / (placed.distance * max(camera.img_size))
            tilt = np.degrees(np.arccos(np.clip(placed.normal[2], -1, 1)))
            tilts_and_widths.append((tilt, width))
        tilts, widths = np.array(tilts_and_widths).reshape(-1, 2).T
        noise = np.ones(len(rt))
        if calibration is not None:
            pairs = zip(calibration.residuals, calibration.used, strict=True)
            # Six points do not measure noise: some pose fits them. Noise below a detector's does not count.
            enough = [(i, e[u]) for i, (e, u) in enumerate(pairs) if u.sum() > 6]
            rms = np.array([np.sqrt(np.mean(np.sum(e**2, axis=1))) for _, e in enough])
            rms = np.maximum(rms, MIN_NOISE_WIDTHS * camera.img_size[0])
            noise[[i for i, _ in enough]] = rms / rms.min(initial=np.inf)
        v = len(rt)
        return cls(tilts[:v], widths[:v], noise, np.stack([tilts[v:], widths[v:]], axis=1))

    def restrict(self, limits: PoseLimits) -> PoseLimits:
        """Limits that exclude poses as hard as those not reached, unless a view has been there."""
        tilt, (low, width) = limits.max_tilt_deg, limits.width
        for t, w in self.unreached:
            # Both are reduced: it is unknown which of them was too hard.
            if t > STEEP_TILT_DEG:
                tilt = min(tilt, max(RETREAT * t, EASY_TILT_DEG, self.tilt.max(initial=0)))
            if w > CLOSE_UP_WIDTH:
                width = min(width, max(RETREAT * w, EASY_WIDTH, self.width.max(initial=0)))
        return replace(limits, max_tilt_deg=float(tilt), width=(low, float(max(width, low))))

    def expected_noise(self, tilt: Array, width: Array) -> Array:
        """Noise (c,) to expect at poses of tilts and widths (c,) / noise of the best view."""
        factor = np.ones(len(tilt))
        if self.tilt.max(initial=0) < STEEP_TILT_DEG:
            factor = np.where(tilt > STEEP_TILT_DEG, UNPROVEN_NOISE_FACTOR, factor)
        if self.width.max(initial=0) < CLOSE_UP_WIDTH:
            factor = np.where(width > CLOSE_UP_WIDTH, factor * UNPROVEN_NOISE_FACTOR, factor)
        for t, w, noise in zip(self.tilt, self.width, self.noise, strict=True):
            if noise < MIN_BAD_NOISE_FACTOR:
                continue
            steeper = (t > STEEP_TILT_DEG - 15) & (tilt > t - 5)
            closer = (w > CLOSE_UP_WIDTH) & (width > 0.9 * w)
            factor = np.where(steeper | closer, np.maximum(factor, noise), factor)
        return factor


SEARCH_COLUMNS = 8
"""Most columns of corners with which candidates are evaluated: those of the default board."""
CANDIDATE_COUNT = 128
ELITE_COUNT, SAMPLES_PER_ELITE = 4, 16
SEARCH_RADII = (0.3, 0.2, 0.14, 0.09, 0.05)
REFINEMENT_RADII = (0.2, 0.12, 0.06)
"""Radii around the elite, / a candidate's range: in a new search, and among earlier candidates."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Candidates, points (c, 6) of the unit cube, and their Fisher information (c, p, p).

    The information is whitened by the posterior's.
    """

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

        `other` (p, p) is added to each.
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

    A corner counts by how probably it is found. Also returns which poses (c,) respect the limits; the
    information of others is 0.
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
