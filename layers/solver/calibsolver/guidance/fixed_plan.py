"""Fixed plan: a sequence of poses chosen beforehand for the prior's camera.

It serves a client that has lost its server, and is the baseline for the guidance that adapts. The criterion
is that of `ProjectionUncertainty`, each pose chosen after those before it. A user who follows the picture
drawn with the prior's camera comes close enough whatever the true focal length is.
"""

import numpy as np

from .. import rotation
from ..board import Board
from .candidates import PoseLimits
from .hints import Placement
from .posterior import IntrinsicsPosterior
from .projection_uncertainty import ProjectionUncertainty
from .target import TargetPose

PLAN_LENGTH = 10
PLAN_LIMITS = PoseLimits(width=(0.35, 1.1), max_tilt_deg=50.0, max_roll_deg=45.0, min_visible=0.75)
"""Narrower than usual: no server checks that the board was found."""


def fixed_plan(board: Board, img_size: tuple[int, int], model: str = "rectilinear") -> tuple[TargetPose, ...]:
    """Poses in their order, as the prior's camera sees them; always the same for the same arguments."""
    chooser = ProjectionUncertainty(board, img_size, model)
    posterior = IntrinsicsPosterior.of(model, img_size, None)
    with np.errstate(all="ignore"):
        chosen = [chooser.first_pose(posterior)]
        for index in range(1, PLAN_LENGTH):
            posterior = chooser.predict_posterior(posterior, chosen[-1])
            r = rotation.matrix(chosen[-1].rvec)
            last = Placement.of(board, posterior.camera, r, chosen[-1].tvec)
            chosen.append(chooser.choose(posterior, index, PLAN_LIMITS, last=last))
    return tuple(chosen)
