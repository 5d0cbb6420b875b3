"""Fixed plan: a sequence of poses chosen beforehand for the prior's camera.

It serves a client that has lost its server, and is the baseline for the guidance that adapts. The criterion
is that of `ProjectionUncertainty`, each pose chosen after those before it. A user who follows the picture
drawn with the prior's camera comes close enough whatever the true focal length is.
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from .. import rotation
from ..board import Board
from ..fitting.calibration import Calibration
from ..view import View
from .candidates import PoseLimits
from .hints import Placement
from .posterior import IntrinsicsPosterior
from .projection_uncertainty import ProjectionUncertainty
from .target import TargetPose

PLAN_LENGTH = 10
PLAN_LIMITS = PoseLimits(width=(0.35, 1.1), max_tilt_deg=50.0, max_roll_deg=45.0, min_visible=0.75)
"""Narrower than usual: no server checks that the board was found."""


class FixedPlan:
    """`PLAN_LENGTH` poses, always the same for a board, an image size and a model."""

    def __init__(self, board: Board, img_size: tuple[int, int], model: str = "rectilinear") -> None:
        self.board = board
        self.img_size = (int(img_size[0]), int(img_size[1]))
        self._chooser = ProjectionUncertainty(board, self.img_size, model)
        self.model = self._chooser.model

    @cached_property
    def poses(self) -> tuple[TargetPose, ...]:
        """Poses in their order, as the prior's camera sees them."""
        posterior = IntrinsicsPosterior.of(self.model.name, self.img_size, None)
        chosen: list[TargetPose] = []
        last: Placement | None = None
        with np.errstate(all="ignore"):
            for index in range(PLAN_LENGTH):
                first = index == 0
                target = (
                    self._chooser.first_pose(posterior)
                    if first
                    else self._chooser.choose(posterior, index, PLAN_LIMITS, last=last)
                )
                chosen.append(target)
                posterior = self._chooser.predict_posterior(posterior, target)
                r = rotation.matrix(target.rvec)
                last = Placement.of(self.board, posterior.camera, r, target.tvec)
        return tuple(chosen)

    def next_pose(
        self,
        views: Sequence[View],
        calibration: Calibration | None = None,
        skipped: Sequence[TargetPose] = (),
        unreached: Sequence[TargetPose] = (),
    ) -> TargetPose:
        """Next pose after those that were answered or skipped; `calibration` changes nothing."""
        del calibration, unreached
        return self.poses[(len(views) + len(skipped)) % PLAN_LENGTH]
