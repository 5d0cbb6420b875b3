"""Thinned moments: fewer corners of each view, so that the time and the memory of a fit are bounded.

The solver's arrays have a column for each corner of the fullest view of each camera, in every moment: one
dense view among many costs as much as if all of them were dense.
"""

from collections.abc import Sequence

import numpy as np

from ..view import View
from .problem import Moment

MAX_ONLINE_POINTS = 16_000
"""Maximum points of a rig's fit during a request: about a second for eight cameras."""
MIN_KEPT_POINTS = 16
"""Points that a view keeps, however many views there are."""
GOLDEN_RATIO = (np.sqrt(5) - 1) / 2


def thin(moments: Sequence[Moment], max_points: int) -> list[Moment]:
    """Return moments whose views have equally many points at most, together `max_points` at most.

    Each view keeps MIN_KEPT_POINTS at least. A view that has no more than its share stays itself.
    """
    count = len(moments) * len({position for moment in moments for position in moment})
    share = max(max_points // max(count, 1), MIN_KEPT_POINTS)
    return [{i: thin_view(view, share) for i, view in moment.items()} for moment in moments]


def thin_view(view: View, count: int) -> View:
    """Return the view with `count` of its points, from all over it; itself if it has no more.

    The points are places of a golden-ratio sequence among those given: these are even whatever the number of
    corners in a row, where equal steps may meet the same column in every row.
    """
    if len(view) <= count:
        return view
    order = np.argsort(np.arange(1, len(view) + 1) * GOLDEN_RATIO % 1.0)
    kept = np.sort(np.argsort(order, kind="stable")[:count])
    return view.subset(kept)
