"""What every guidance can do."""

from collections.abc import Sequence
from typing import Protocol

from ..fitting.calibration import Calibration
from ..view import View
from .target import TargetPose


class Guide(Protocol):
    """Chooses poses; which of them were answered is all it is told."""

    def next_pose(
        self,
        views: Sequence[View],
        calibration: Calibration | None,
        skipped: Sequence[TargetPose] = (),
        unreached: Sequence[TargetPose] = (),
    ) -> TargetPose:
        """Choose the pose of the next view.

        Parameters
        ----------
        views, calibration
            The views so far, and the estimate from them; None where there is none yet.
        skipped
            Targets given up since the last view.
        unreached
            Targets given up before that.
        """
