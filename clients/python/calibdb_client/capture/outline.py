"""Outlines of boards, quadrilaterals (4, 2) px, clockwise from the first corner, and their targets."""

import math
from typing import Any

import numpy as np

from calibsolver.arrays import Array
from calibsolver.guidance import hints

from ..board import MIN_CORNERS, Board, opencv

MASK_PX = 4
"""Side of a pixel of the masks by which areas are compared, px of the image."""
FAR_SIZES = 0.1
"""Distance of two middles / the target's size, that a hand may miss by,"""
LARGER_RATIO = 1.15
"""ratio of the sizes,"""
TURNED_RAD = 0.14
"""turn,"""
TILTED_LOG = 0.06
"""and difference in the logarithm of how much longer one side is than the opposite one."""

TEXTS: dict[str, str] = {
    **{code: text[0].lower() + text[1:] for code, text in hints.TEXTS.items()},
    "tilt_top": "tilt the top edge towards the camera",
    "tilt_bottom": "tilt the bottom edge towards the camera",
    "tilt_left": "tilt the left edge towards the camera",
    "tilt_right": "tilt the right edge towards the camera",
    "hold_still": "hold the board still",
}
"""Instructions by code. Sides are those of the camera's picture."""


def outline_of(board: Board, ids: Any, points: Any) -> Array | None:
    """Return the board's edge (4, 2) px by the homography of its corners (n, 2) px; None if they fix none."""
    if len(ids) < MIN_CORNERS:
        return None
    matrix, _ = opencv().findHomography(board.places[list(ids)], np.asarray(points, dtype=np.float64), 0)
    if matrix is None:
        return None
    edge = np.column_stack([board.edge, np.ones(4)]) @ matrix.T
    middle = np.append(board.edge.mean(axis=0), 1) @ matrix[2]
    if (edge[:, 2] * middle <= 0).any():
        return None
    outline: Array = edge[:, :2] / edge[:, 2:]
    return outline if np.isfinite(outline).all() else None


def overlap(one: Array, other: Array, size: tuple[int, int]) -> float:
    """Area of the intersection / area of the union of two polygons (m, 2) px, inside the image."""
    first, second = _mask(one, size), _mask(other, size)
    union = int(np.count_nonzero(first | second))
    return float(np.count_nonzero(first & second) / union) if union else 0.0


def difference(outline: Array, target: Array) -> float:
    """Difference of two poses of the board, sizes and places made equal, as a share of its size.

    A hand that misses by 3 degrees is below 0.07; a board that faces the camera in a target tilted by 35
    degrees is above 0.085.
    """
    return _spread(_alike(upright(outline, target)), _alike(target))


def foreshortening(outline: Array) -> float:
    """Ratio of opposite sides, less 1, the larger of both: 0 of a board that faces the camera."""
    return max(math.expm1(abs(_ratio(outline, side))) for side in (0, 1))


def upright(outline: Array, target: Array) -> Array:
    """Return the outline turned by half a turn, if it is nearer to the target's so."""
    turned = np.roll(outline, -2, axis=0)
    return turned if _spread(turned, target) < _spread(outline, target) else outline


def advice(outline: Array, target: Array, tolerance: float = 1.0) -> str:
    """Return the code of the movement that is farthest from done; "" if the board is at the target.

    `tolerance` is the factor on what a hand may miss by.
    """
    current = upright(outline, target)
    size = _size(target)
    right, down = (target.mean(axis=0) - current.mean(axis=0)) / size
    across = ("right" if right > 0 else "left") if abs(right) >= abs(down) else ("down" if down > 0 else "up")
    larger = math.log(size / _size(current))
    turn = _direction(target) - _direction(current)
    turn = math.atan2(math.sin(turn), math.cos(turn))
    candidates = [
        (math.hypot(right, down) / FAR_SIZES, across),
        (abs(larger) / math.log(LARGER_RATIO), "closer" if larger > 0 else "farther"),
        (abs(turn) / TURNED_RAD, "turn_clockwise" if turn > 0 else "turn_counterclockwise"),
        _tilt(current, target),
    ]
    excess, code = max(candidates)
    return code if excess > tolerance else ""


def _tilt(outline: Array, target: Array) -> tuple[float, str]:
    """Nearer sides look longer, the more so the larger the board looks: compared at the same size."""
    larger = _size(target) / _size(outline)
    first, second = (_ratio(target, side) - larger * _ratio(outline, side) for side in (0, 1))
    steeper = abs(first) > abs(second)
    side = (0 if first > 0 else 2) if steeper else (1 if second > 0 else 3)
    x, y = (target[side] + target[(side + 1) % 4]) / 2 - target.mean(axis=0)
    name = ("left" if x < 0 else "right") if abs(x) > abs(y) else ("top" if y < 0 else "bottom")
    return max(abs(first), abs(second)) / TILTED_LOG, f"tilt_{name}"


def _ratio(outline: Array, side: int) -> float:
    lengths = np.linalg.norm(outline - np.roll(outline, -1, axis=0), axis=1)
    return math.log(max(float(lengths[side]), 1e-9) / max(float(lengths[side + 2]), 1e-9))


def _size(outline: Array) -> float:
    """Square root of the area, px."""
    x, y = outline.T
    area = float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2
    return max(math.sqrt(abs(area)), 1e-9)


def _direction(outline: Array) -> float:
    """Angle of the board's rows, rad."""
    a, b, c, d = outline
    x, y = b - a + c - d
    return math.atan2(y, x)


def _alike(outline: Array) -> Array:
    alike: Array = (outline - outline.mean(axis=0)) / _size(outline)
    return alike


def _spread(one: Array, other: Array) -> float:
    return float(np.linalg.norm(one - other, axis=1).mean())


def _mask(polygon: Array, size: tuple[int, int]) -> Any:
    w, h = size
    mask = np.zeros((-(-h // MASK_PX), -(-w // MASK_PX)), dtype=np.uint8)
    if len(polygon) >= 3:
        corners = np.clip((polygon + 0.5) / MASK_PX - 0.5, -1e4, 1e4)
        opencv().fillPoly(mask, [np.round(corners * 16).astype(np.int32)], 1, shift=4)
    return mask
