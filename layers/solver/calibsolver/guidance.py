"""Where to hold the board next: there where the projection over the image gains most.

A view adds its information S to that of the intrinsics; the mean square projection error over the image is
trace(covariance W) (`uncertainty.weight`). Of some hundred poses that a person can hold the one is taken after which
that is least. The idea of choosing views by expected error is AprilCal's (Richardson, Strom, Olson, IROS 2013) and
Calibration Wizard's (Peng, Sturm, ICCV 2019); the measure, the error over the image up to a rotation, is mrcal's.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from . import candidates, models, normal, prior, rotation, uncertainty
from .arrays import Array, Mask, symmetric_inverse
from .board import Board
from .calibration import Calibration
from .camera import Camera
from .candidates import Range
from .models import Model
from .target import TargetPose
from .view import View

__all__ = ["Belief", "ProjectionUncertainty", "TargetPose"]

CANDIDATES = 300
BEST = 4
"""How many of the candidates are refined."""
GRID = (12, 9)
NOMINAL_NOISE = 0.3 / 1280
"""Standard deviation of a corner's coordinate / image width, before anything was measured."""
LEAST_NOISE = 0.05 / 1280
"""No detector is better than this; views that fit by luck do not promise it either."""
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

    def weight(self) -> Array:
        """W (p, p), see `uncertainty.weight`."""
        return uncertainty.weight(uncertainty.sensitivity(self.model, self.k, self.img_size, GRID))

    def gain(self, information: Array) -> float:
        """px^2 by which views of `information` (p, p) at unit noise lower the mean square projection error."""
        w = self.weight()
        before = symmetric_inverse(self.information)
        after = symmetric_inverse(self.information + information / self.noise**2)
        return float(np.sum((before - after) * w))


class ProjectionUncertainty:
    """The default guidance; see the module's docstring."""

    def __init__(self, board: Board, img_size: tuple[int, int], model: str = "rectilinear") -> None:
        self.board = board
        self.img_size = (int(img_size[0]), int(img_size[1]))
        self.model = models.get(model)
        self._points = np.ascontiguousarray(board.points.T)

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
                return self._first(belief)
            limits = limits or (EASY if skipped else Range())
            chosen = self._best(belief, len(views), limits, skipped)
            if chosen is None:
                return self._first(Belief.of(self.model.name, self.img_size, None))
            return chosen

    def _first(self, belief: Belief) -> TargetPose:
        """Easy: all of the board in the middle, two thirds of the width, tilted about a diagonal."""
        w, h = self.img_size
        aspect = self.board.size[1] / self.board.size[0]
        width = min(0.68, 0.68 * h / (w * aspect))
        limits = Range(width=(width, width), tilt=30.0, roll=0.0)
        unit = np.array([[0.5, 0.5, 0.5, 1.0, 0.82, 0.5]])
        poses = candidates.poses(unit, self.board, belief.model, belief.k, self.img_size, limits)
        s, _, _ = self._information(belief, poses, limits)
        camera = belief.camera
        return TargetPose.seen(self.board, camera, poses.r[0], poses.t[0], "a first look", belief.gain(s[0]))

    def _information(self, belief: Belief, poses: normal.Poses, limits: Range) -> tuple[Array, Mask, Mask]:
        """Information (c, p, p) at unit noise of poses (c), corners seen (c, n), and whether each may be asked for."""
        points = np.broadcast_to(self._points, (len(poses.t), *self._points.shape))
        p = poses.camera_points(points)
        q = belief.model.project(belief.k, p.transpose(1, 0, 2)).transpose(1, 0, 2)
        seen, good = candidates.visible(
            p, q, poses.r[:, :, 2], self.board, belief.model, belief.k, self.img_size, limits
        )
        s = np.zeros((len(points), belief.model.size, belief.model.size))
        use = np.flatnonzero(good) if len(points) > 1 else np.arange(1)
        if use.size:
            _, j = normal.design(
                belief.model, belief.k, normal.Poses(poses.r[use], poses.t[use]), points[use]
            )
            j = np.where(seen[use][:, None, None, :], j, 0.0)
            s[use] = normal.information(j, seen[use].astype(np.float64))
        return s, seen, good

    def _score(
        self, belief: Belief, unit: Array, limits: Range, weight: Array
    ) -> tuple[Array, normal.Poses, Array]:
        """Mean square projection error (c,) px^2 after each candidate, inf where it may not be asked for."""
        poses = candidates.poses(unit, self.board, belief.model, belief.k, self.img_size, limits)
        s, _, good = self._information(belief, poses, limits)
        score = np.full(len(unit), np.inf)
        use = np.flatnonzero(good)
        if use.size:
            after = symmetric_inverse(belief.information + s[use] / belief.noise**2)
            score[use] = np.einsum("cij,ij->c", after, weight)
        return score, poses, s

    def _best(
        self, belief: Belief, index: int, limits: Range, skipped: Sequence[TargetPose]
    ) -> TargetPose | None:
        weight = belief.weight()
        unit = candidates.sequence(CANDIDATES, index + 7 * len(skipped))
        score, poses, s = self._score(belief, unit, limits, weight)
        for target in skipped:
            score[self._alike(poses, target)] = np.inf
        order = np.argsort(score)[:BEST]
        order = order[np.isfinite(score[order])]
        if not order.size:
            return None
        best, best_score = (poses.r[order[0]], poses.t[order[0]], s[order[0]]), score[order[0]]
        around = candidates.sequence(8, 1) - 0.5
        for radius in (0.16, 0.06):
            near = (unit[order][:, None, :] + radius * around).reshape(-1, candidates.DIMENSIONS)
            near[:, 4] %= 1.0
            near = np.clip(near, 0.0, 1.0)
            score, poses, s = self._score(belief, near, limits, weight)
            for target in skipped:
                score[self._alike(poses, target)] = np.inf
            order = np.argsort(score)[:BEST]
            unit = near
            if score[order[0]] < best_score:
                best, best_score = (poses.r[order[0]], poses.t[order[0]], s[order[0]]), score[order[0]]
        before = symmetric_inverse(belief.information)
        gain = float(np.sum(before * weight)) - float(best_score)
        purpose = self._purpose(belief, before, best[2])
        return TargetPose.seen(self.board, belief.camera, best[0], best[1], purpose, gain)

    def _alike(self, poses: normal.Poses, target: TargetPose) -> Array:
        """Which poses (c) look much like a target: normals within 20 degrees and centres within 1.5 squares."""
        r = rotation.matrix(target.rvec)
        center = self.board.outline.mean(axis=0)
        place = np.linalg.norm(poses.r @ center + poses.t - (r @ center + target.tvec), axis=1)
        angle = poses.r[:, :, 2] @ r[:, 2]
        alike: Array = (angle > np.cos(np.radians(20))) & (place < 1.5)
        return alike

    def _purpose(self, belief: Belief, before: Array, s: Array) -> str:
        """Name the group of parameters that the view pins down most."""
        after = symmetric_inverse(belief.information + s / belief.noise**2)
        left = np.diagonal(after) / np.diagonal(before)
        groups = {
            "the focal length": left[:2].min(),
            "the centre of the image": left[2:4].min(),
            "the distortion": left[4:].min(),
        }
        return f"to measure {min(groups, key=lambda name: float(groups[name]))}"
