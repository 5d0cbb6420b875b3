"""Where to hold the board next: there where the projection over the image gains most.

A view adds its information S to that of the intrinsics; the mean square projection error over the image is
trace(covariance W) (`uncertainty.weight`). Of some hundred poses that a person can hold the one is taken
after which that is least. The idea of choosing views by expected error is AprilCal's (Richardson, Strom,
Olson, IROS 2013) and Calibration Wizard's (Peng, Sturm, ICCV 2019); the measure, the error over the image
up to a rotation, is mrcal's.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .. import models, rotation
from ..arrays import Array, symmetric_inverse
from ..board import Board
from ..camera import Camera
from ..fitting import normal_equations
from ..fitting.calibration import Calibration
from ..view import View
from . import candidates
from .belief import Belief
from .candidates import Lattice, Range
from .experience import Experience
from .hints import Placement
from .search import Search, information
from .target import TargetPose

ANY = Range(inside=0.0, oblique=90.0, spacing=0.0)
"""Whatever comes: for a pose that has been chosen already."""
PLENTY = 10
"""Corners that a target shows at least, of a board that has so many: a hand misses by some."""
EASY = Range(width=(0.45, 0.75), tilt=30.0, roll=15.0, inside=1.0)
"""A pose for someone who could not reach the last one: little tilt, all of the board in the picture."""
TIE = 1.02
"""Scores within this factor of the best are as good: of these the pose nearest to the hand's is taken."""
PLANNED = 2
"""Views from which each is chosen by itself; before, the next and the one after it together."""
ARM = 3.0
"""Lengths of the board that it may be away, unless the lens is so long that it would not fit otherwise."""


class ProjectionUncertainty:
    """The default guidance; see the module's docstring.

    Parameters
    ----------
    board, img_size, model
        What is captured with what; width and height in px.
    seed
        Initial camera, as others have measured it: the intrinsics before the first view.
    """

    def __init__(
        self,
        board: Board,
        img_size: tuple[int, int],
        model: str = "rectilinear",
        seed: Camera | None = None,
    ) -> None:
        self.board = board
        self.img_size = (int(img_size[0]), int(img_size[1]))
        self.model = models.get(model)
        self.seed = seed
        self._all = Lattice.of(board, None)

    def next_pose(
        self,
        views: Sequence[View],
        calibration: Calibration | None,
        skipped: Sequence[TargetPose] = (),
        unreached: Sequence[TargetPose] = (),
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
        unreached
            Targets given up earlier in this session: as far as they were hard, less is asked from now on.
        limits
            What may be asked of the user.
        """
        belief = Belief.of(self.model.name, self.img_size, calibration, self.seed)
        # Estimates may be wild at first: what overflows is refused as invisible.
        with np.errstate(all="ignore"):
            if not views and not skipped:
                return self.first_pose(belief)
            experience = Experience.of(self.board, belief.camera, belief.sight.focal, calibration, unreached)
            limits = limits or experience.within(EASY if skipped else Range())
            last = None
            if calibration is not None:
                r, t = rotation.matrix(calibration.poses[-1, :3]), calibration.poses[-1, 3:]
                last = Placement.of(self.board, belief.camera, r, t)
            ahead = 2 if 0 < len(views) < PLANNED else 1
            return self.choose(belief, len(views), limits, ahead, tuple(skipped), experience, last)

    def first_pose(self, belief: Belief) -> TargetPose:
        """Easy: all of the board in the middle, two thirds of the image, tilted about a diagonal."""
        return self._first(belief, belief)

    def choose(
        self,
        belief: Belief,
        index: int,
        limits: Range,
        ahead: int = 1,
        skipped: tuple[TargetPose, ...] = (),
        experience: Experience | None = None,
        last: Placement | None = None,
    ) -> TargetPose:
        """Choose by what is believed, as the next of `ahead` views; `index` varies the search."""
        whole = min(1.0, PLENTY / self.board.corner_count)
        low, high = limits.width
        reach = belief.sight.focal / (ARM * max(self.img_size))
        limits = replace(
            limits, inside=max(limits.inside, whole), width=(min(max(low, reach), max(low, 0.6 * high)), high)
        )
        found = Search(self.board, belief, limits, skipped, experience).best(index, ahead)
        if found is None:
            return self._first(Belief.of(self.model.name, self.img_size, None, self.seed), belief)
        unit, score = found
        ties = int(np.count_nonzero(score <= TIE * score.min()))  # none where rounding is all there is
        unit = unit[np.argsort(score)][: max(ties, 1)]
        poses = candidates.poses(unit, self.board, belief.sight, limits)
        pick = 0 if last is None else int(np.argmin(self._way(poses, last)))
        r, t = poses.r[pick], poses.t[pick]
        s, _ = information(belief, normal_equations.Poses(r[None], t[None]), self._all, ANY)
        gain = belief.gain(s[0])
        return TargetPose.seen(self.board, belief.camera, r, t, self._purpose(belief, s[0]), gain, last)

    def after(self, belief: Belief, target: TargetPose) -> Belief:
        """Return what will be known after a view of the target."""
        poses = normal_equations.Poses(rotation.matrix(target.rvec[None]), target.tvec[None])
        with np.errstate(all="ignore"):
            s, _ = information(belief, poses, self._all, ANY)
        return replace(belief, information=belief.information + s[0] / belief.noise**2)

    def _first(self, belief: Belief, known: Belief) -> TargetPose:
        """Place the first pose by one belief; what it would bring is told by what is `known`."""
        image, board = sorted(self.img_size), sorted(self.board.size)
        length = min(0.72, 0.72 * image[0] * board[1] / (image[1] * board[0]))
        limits = Range(width=(length, length), tilt=44.0, roll=0.0)
        unit = np.array([[0.5, 0.5, 0.5, 1.0, 0.82, 0.5]])
        poses = candidates.poses(unit, self.board, belief.sight, limits)
        s, _ = information(belief, poses, self._all, ANY)
        return TargetPose.seen(
            self.board, belief.camera, poses.r[0], poses.t[0], "a first look", known.gain(s[0])
        )

    def _way(self, poses: normal_equations.Poses, last: Placement) -> Array:
        """How far (c,) the hand moves: distance in squares of the board's length, and the change of tilt."""
        center = poses.r @ self.board.outline.mean(axis=0) + poses.t
        far = np.abs(np.log(np.linalg.norm(center, axis=1) / last.distance))
        lean = np.linalg.norm(poses.r[:, :, 2] - last.normal, axis=1)
        way: Array = far + lean
        return way

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
