"""Recognition of the board and of the corner ids of imported views."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array
from ..view import View
from . import text

MAX_CORNER_OFFSET = 0.02
"""Squares by which a point may lie off its corner."""
MAX_BOARD_SIDE = 64


@dataclass(frozen=True)
class Grid:
    """Views of a board of corners: (columns, rows) of its squares, and the ids of the points of each view."""

    squares: tuple[int, int]
    ids: tuple[tuple[int, ...], ...]


def grid(views: Sequence[View]) -> Grid:
    """Recognise the rows and columns of a board in the coordinates of its points, whatever their unit.

    Raises CalibrationError ``malformed`` if they are not those of a flat board with square fields.
    """
    if not views:
        raise text.refuse("there are no views")
    points = np.concatenate([view.object_points for view in views])
    x, y = _axis(points[:, 0]), _axis(points[:, 1])
    unit = min(_step(x), _step(y))
    if np.ptp(points[:, 2]) > MAX_CORNER_OFFSET * unit:
        raise text.refuse("the board is not flat")
    columns, rows = (round(float(np.ptp(axis)) / unit) + 1 for axis in (x, y))
    if not (2 <= columns < MAX_BOARD_SIDE and 2 <= rows < MAX_BOARD_SIDE):
        raise text.refuse(f"{columns} x {rows} corners do not match a known board")
    ids = []
    for view in views:
        at = (view.object_points[:, :2] - (x[0], y[0])) / unit
        index = at.round()
        if np.abs(at - index).max() > MAX_CORNER_OFFSET:
            raise text.refuse("the points do not lie in rows and columns of one distance")
        corner_ids = (index[:, 1] * columns + index[:, 0]).astype(int).tolist()
        if len(set(corner_ids)) != len(corner_ids):
            raise text.refuse("a view has a corner twice")
        ids.append(tuple(corner_ids))
    return Grid((columns + 1, rows + 1), tuple(ids))


def _axis(values: Array) -> Array:
    """Return the distinct coordinates in order."""
    order = np.sort(values)
    reach = max(float(np.ptp(order)), 1e-12)
    new = np.concatenate([[True], np.diff(order) > 1e-6 * reach])
    positions: Array = order[new]
    if len(positions) < 2:
        raise text.refuse("the points lie on a line")
    return positions


def _step(axis: Array) -> float:
    return float(np.diff(axis).min())
