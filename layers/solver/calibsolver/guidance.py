"""Where to hold the board next: there where the projection over the image gains most.

A view adds its information S to that of the intrinsics; the mean square projection error over the image is
trace(covariance W) (`uncertainty.weight`). Of some hundred poses that a person can hold the one is taken
after which that is least. The idea of choosing views by expected error is AprilCal's (Richardson, Strom,
Olson, IROS 2013) and Calibration Wizard's (Peng, Sturm, ICCV 2019); the measure, the error over the image
up to a rotation, is mrcal's.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from . import candidates, models, normal, prior, rotation, uncertainty
from .arrays import Array, Mask, symmetric_inverse
from .board import Board
from .calibration import Calibration
from .camera import Camera
from .candidates import Lattice, Range, Sight
from .models import Model
from .target import TargetPose
from .view import View

__all__ = ["Belief", "ProjectionUncertainty", "TargetPose"]

CANDIDATES = 128
BEST, AROUND = 4, 16
"""How many of the candidates are refined, and how many are tried around each."""
RADII = (0.3, 0.22, 0.16, 0.12, 0.08, 0.06, 0.04)
"""How far around, in units of a candidate's range."""
GRID = (12, 9)
NOMINAL_NOISE = 0.3 / 1280
"""Standard deviation of a corner's coordinate / image width, before anything was measured."""
LEAST_NOISE = 0.05 / 1280
"""No detector is better than this; views that fit by luck do not promise it either."""
ANY = Range(inside=0.0, oblique=90.0, spacing=0.0)
"""Whatever comes: for a pose that has been chosen already."""
PLENTY = 10
"""Corners that a target shows at least, of a board that has so many: a hand misses by some."""
EASY = Range(width=(0.45, 0.75), tilt=30.0, roll=15.0, inside=1.0)
"""A pose for someone who could not reach the last one: little tilt, all of the board in the picture."""


@dataclass(frozen=True, eq=False)
class Belief:
    """What is known of the intrinsics: values (p,), information (p, p), and noise of a corner, px."""

    model: Model
    k: Array
    information: Array
    noise: float
    img_size: tuple[int, int]

    @classmethod
    def of(cls, model: str, img_size: tuple[int, int], calibration: Calibration | None) -> "Belief":
        """From a calibration, or from the model's prior alone."""
        law = models.get(model)
        w = img_size[0]
        if calibration is None:
            k = law.start(law.prior.focal * w, img_size)
            return cls(law, k, prior.information(law, k, img_size), NOMINAL_NOISE * w, img_size)
        k = calibration.camera.intrinsics
        noise = max(calibration.noise, LEAST_NOISE * w)
        covariance = calibration.covariance * (noise / max(calibration.noise, 1e-12)) ** 2
        return cls(law, k, symmetric_inverse(covariance), noise, img_size)

    @property
    def camera(self) -> Camera:
        """The camera at the believed intrinsics."""
        return Camera.from_intrinsics(self.model.name, self.k, self.img_size)

    @cached_property
    def sight(self) -> Sight:
        """Rays over the image."""
        return Sight.of(self.model, self.k, self.img_size)

    @cached_property
    def weight(self) -> Array:
        """W (p, p), see `uncertainty.weight`."""
        return uncertainty.weight(uncertainty.sensitivity(self.model, self.k, self.img_size, GRID))

    def gain(self, information: Array) -> float:
        """Return how far views of `information` (p, p) at unit noise lower the mean square error, px^2."""
        w = self.weight
        before = symmetric_inverse(self.information)
        after = symmetric_inverse(self.information + information / self.noise**2)
        return float(np.sum((before - after) * w))


@dataclass(frozen=True, eq=False)
class Goal:
    """What a candidate is judged by: W (p, p) (`uncertainty.weight`), and targets it must not resemble."""

    weight: Array
    skipped: tuple[TargetPose, ...]


class ProjectionUncertainty:
    """The default guidance; see the module's docstring."""

    def __init__(self, board: Board, img_size: tuple[int, int], model: str = "rectilinear") -> None:
        self.board = board
        self.img_size = (int(img_size[0]), int(img_size[1]))
        self.model = models.get(model)
        self._all = Lattice.of(board, None)
        self._thin = Lattice.of(board, 5)

    def next_pose(
        self,
        views: Sequence[View],
        calibration: Calibration | None,
        skipped: Sequence[TargetPose] = (),
        limits: Range | None = None,
    ) -> TargetPose:
        """Choose the pose of the next view.

        Parameters
        ----------
        views
            The views so far; their number alone varies the choice where much is equally good.
        calibration
            The estimate from them, or None where there is none yet.
        skipped
            Targets the user could not reach: one unlike them is chosen, easy to hold and wholly visible.
        limits
            What may be asked of the user.
        """
        belief = Belief.of(self.model.name, self.img_size, calibration)
        # Estimates may be wild at first: what overflows is refused as invisible.
        with np.errstate(all="ignore"):
            if not views and not skipped:
                return self._first(belief, belief)
            limits = limits or (EASY if skipped else Range())
            whole = min(1.0, PLENTY / self.board.corner_count)
            limits = replace(limits, inside=max(limits.inside, whole))
            chosen = self._best(belief, len(views), limits, Goal(belief.weight, tuple(skipped)))
            if chosen is None:
                return self._first(Belief.of(self.model.name, self.img_size, None), belief)
            return chosen

    def _first(self, belief: Belief, known: Belief) -> TargetPose:
        """Easy: all of the board in the middle, two thirds of the image, tilted about a diagonal.

        Placed by one belief; what it would bring is told by what is `known`.
        """
        image, board = sorted(self.img_size), sorted(self.board.size)
        length = min(0.68, 0.68 * image[0] * board[1] / (image[1] * board[0]))
        limits = Range(width=(length, length), tilt=40.0, roll=0.0)
        unit = np.array([[0.5, 0.5, 0.5, 1.0, 0.82, 0.5]])
        poses = candidates.poses(unit, self.board, belief.sight, limits)
        s, _ = self._information(belief, poses, ANY, thin=False)
        return TargetPose.seen(
            self.board, belief.camera, poses.r[0], poses.t[0], "a first look", known.gain(s[0])
        )

    def _information(
        self, belief: Belief, poses: normal.Poses, limits: Range, thin: bool
    ) -> tuple[Array, Mask]:
        """Information (c, p, p) at unit noise of poses (c), and whether each may be asked for (0 where not).

        `thin` looks at a lattice of a dozen corners that stand for all of them.
        """
        lattice = self._thin if thin else self._all
        p = poses.r @ lattice.points + poses.t[:, :, None]
        q = belief.model.project(belief.k, p.transpose(1, 0, 2)).transpose(1, 0, 2)
        seen, good = candidates.visible(
            p, q, poses.r[:, :, 2], lattice, belief.model, belief.k, self.img_size, limits
        )
        good &= (thin is False) | candidates.in_front(poses, self.board, belief.sight)
        use = np.flatnonzero(good)
        s = np.zeros((len(good), belief.model.size, belief.model.size))
        if use.size:
            _, j = normal.design(
                belief.model, belief.k, normal.Poses(poses.r[use], poses.t[use]), lattice.points
            )
            seen = seen[use]
            j = np.where(seen[:, None, None, :], j, 0.0)
            s[use] = normal.information(j, seen.astype(np.float64) * lattice.share)
        return s, good

    def _score(self, belief: Belief, unit: Array, limits: Range, goal: Goal) -> Array:
        """Mean square projection error (c,) px^2 after each candidate (c, 6), inf where it is no good."""
        poses = candidates.poses(unit, self.board, belief.sight, limits)
        s, good = self._information(belief, poses, limits, thin=True)
        score = np.full(len(unit), np.inf)
        for target in goal.skipped:
            good &= ~self._alike(poses, target)
        use = np.flatnonzero(good)
        if use.size:
            after = symmetric_inverse(belief.information + s[use] / belief.noise**2)
            score[use] = np.einsum("cij,ij->c", after, goal.weight)
        return score

    def _best(self, belief: Belief, index: int, limits: Range, goal: Goal) -> TargetPose | None:
        """Search by the cross-entropy method: spread widely, then ever closer around the best so far."""
        unit = candidates.sequence(CANDIDATES, index + 7 * len(goal.skipped))
        score = self._score(belief, unit, limits, goal)
        around = candidates.sequence(AROUND * BEST, 1) - 0.5
        for radius in RADII:
            best = np.argsort(score)[:BEST]
            near = np.repeat(unit[best], AROUND, axis=0) + 2 * radius * around
            near[:, 4] %= 1.0
            near = np.clip(near, 0.0, 1.0)
            unit = np.concatenate([unit[best], near])
            score = np.concatenate([score[best], self._score(belief, near, limits, goal)])
        order = np.argsort(score)
        if not np.isfinite(score[order[0]]):
            return None
        pick = unit[order[:1]]
        poses = candidates.poses(pick, self.board, belief.sight, limits)
        s, _ = self._information(belief, poses, ANY, thin=False)
        return TargetPose.seen(
            self.board, belief.camera, poses.r[0], poses.t[0], self._purpose(belief, s[0]), belief.gain(s[0])
        )

    def _alike(self, poses: normal.Poses, target: TargetPose) -> Mask:
        """Whether poses (c) are much like a target: normals within 20 degrees, centres within 1.5 squares."""
        r = rotation.matrix(target.rvec)
        center = self.board.outline.mean(axis=0)
        place = np.linalg.norm(poses.r @ center + poses.t - (r @ center + target.tvec), axis=1)
        angle = poses.r[:, :, 2] @ r[:, 2]
        alike: Mask = (angle > np.cos(np.radians(20))) & (place < 1.5)
        return alike

    def _purpose(self, belief: Belief, s: Array) -> str:
        """Name the group of parameters that the view pins down most."""
        before = symmetric_inverse(belief.information)
        after = symmetric_inverse(belief.information + s / belief.noise**2)
        left = np.diagonal(after) / np.diagonal(before)
        groups = {
            "the focal length": left[:2].min(),
            "the centre of the image": left[2:4].min(),
            "the distortion": left[4:].min(),
        }
        return f"to measure {min(groups, key=lambda name: float(groups[name]))}"
