"""Interface of every guidance."""

from collections.abc import Sequence
from typing import Protocol

from ..fitting.calibration import Calibration
from ..view import View
from .target import TargetPose


class Guide(Protocol):
    """Chooser of poses; its only input is which of them were answered, and the estimate."""

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
            The views so far, and the estimate from them; None if there is none yet.
        skipped
            Targets given up since the last view.
        unreached
            Targets given up before that.
        """
