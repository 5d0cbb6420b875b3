"""The plan that asks nobody: poses chosen beforehand for a camera like most.

For a client that has lost its server, and as the peer that shows what adapting brings. The criterion is that
of `ProjectionUncertainty`, each pose chosen after those before it, at the prior's camera. Whoever follows the
picture drawn with that camera comes close enough whatever the true focal length is.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from .. import rotation
from ..board import Board
from ..fitting.calibration import Calibration
from ..view import View
from .belief import Belief
from .candidates import Range
from .hints import Placement
from .projection_uncertainty import ProjectionUncertainty
from .target import TargetPose

LENGTH = 10
PLANNED = Range(width=(0.35, 1.1), tilt=50.0, roll=45.0, inside=0.75)
"""Nobody can say whether the board was seen, so it is asked for where it surely is."""


class FixedPlan:
    """`LENGTH` poses, always the same for a board, an image size and a model."""

    def __init__(self, board: Board, img_size: tuple[int, int], model: str = "rectilinear") -> None:
        self.board = board
        self.img_size = (int(img_size[0]), int(img_size[1]))
        self._chooser = ProjectionUncertainty(board, self.img_size, model)
        self.model = self._chooser.model

    @cached_property
    def poses(self) -> tuple[TargetPose, ...]:
        """The poses in their order, as the prior's camera sees them."""
        belief = Belief.of(self.model.name, self.img_size, None)
        chosen: list[TargetPose] = []
        last: Placement | None = None
        with np.errstate(all="ignore"):
            for index in range(LENGTH):
                first = index == 0
                target = (
                    self._chooser.first_pose(belief)
                    if first
                    else self._chooser.choose(belief, index, PLANNED, last=last)
                )
                chosen.append(target)
                belief = self._chooser.after(belief, target)
                r = rotation.matrix(target.rvec)
                last = Placement.of(self.board, belief.camera, r, target.tvec)
        return tuple(chosen)

    def next_pose(
        self,
        views: Sequence[View],
        calibration: Calibration | None = None,
        skipped: Sequence[TargetPose] = (),
        unreached: Sequence[TargetPose] = (),
    ) -> TargetPose:
        """Return the pose after those that were answered or skipped; `calibration` changes nothing."""
        del calibration, unreached
        return self.poses[(len(views) + len(skipped)) % LENGTH]
