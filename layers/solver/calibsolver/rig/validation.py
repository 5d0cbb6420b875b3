"""Checks of what a rig is to be fitted to."""

from collections.abc import Sequence

from ..errors import CalibrationError
from .problem import Moment
from .single import Specification

MIN_RIG_CAMERAS, MAX_RIG_CAMERAS = 2, 8
MAX_MOMENTS = 1000


def check(moments: Sequence[Moment], cameras: Sequence[Specification]) -> None:
    """Raise CalibrationError (``bad_rig``, ``no_views``, ``unlinked``) unless every camera has views."""
    if not MIN_RIG_CAMERAS <= len(cameras) <= MAX_RIG_CAMERAS:
        raise CalibrationError(
            "bad_rig", f"a rig has {MIN_RIG_CAMERAS} to {MAX_RIG_CAMERAS} cameras, not {len(cameras)}"
        )
    if not 1 <= len(moments) <= MAX_MOMENTS:
        raise CalibrationError(
            "no_views", f"a rig is fitted to 1 to {MAX_MOMENTS} moments, not {len(moments)}"
        )
    for m, moment in enumerate(moments):
        for position in moment:
            if position not in range(len(cameras)):
                raise CalibrationError(
                    "bad_rig", f"moment {m} has a view of camera {position}: there are {len(cameras)}"
                )
    for position in range(len(cameras)):
        if not any(position in moment for moment in moments):
            raise CalibrationError("unlinked", f"camera {position} has no view")
