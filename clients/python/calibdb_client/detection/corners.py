"""Corners of a board in one picture, and their refinement to a fraction of a pixel."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from calibsolver.arrays import Array

from ..board import MIN_CORNERS, Board

MIN_SQUARE_PX = 12.0
"""Side of a square, or of a tag, in the picture; corners of smaller ones are not measured well."""
MAX_REFINEMENT_PX = 2.0
"""Distance by which refinement may move a corner; one that moves farther is not a corner."""
STEPS = (3, 40, 0.001)  # by count and by change, iterations, px


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners found in one picture: ids (n,), and points (n, 2) px."""

    ids: tuple[int, ...]
    points: Array


def refine(grey: Any, board: Board, ids: Any, coarse: Any) -> Corners | None:
    """Refine corners (n, 2) px in a picture (h, w) by `cv2.cornerSubPix`; None if too few of them remain."""
    import cv2

    sides = _sides(board, ids, coarse)
    # A window that holds no other edge than those that meet in the corner
    width = sides * (min(board.tag_spacing, 1.0) if board.kind == "aprilgrid" else 1.0)
    fine = np.ascontiguousarray(coarse, dtype=np.float32).copy()
    inside = ((coarse >= 0) & (coarse <= np.array(grey.shape[::-1]) - 1)).all(axis=1)
    for n, room in enumerate(width):
        if not inside[n]:  # of a tag that the picture cuts off
            continue
        half = int(np.clip(round(float(room) / 8), 2, 6))
        cv2.cornerSubPix(grey, fine[n : n + 1], (half, half), (-1, -1), STEPS)
    moved = np.linalg.norm(fine - coarse, axis=1)
    indices = np.flatnonzero(inside & (sides >= MIN_SQUARE_PX) & (moved <= MAX_REFINEMENT_PX))
    if len(indices) < MIN_CORNERS:
        return None
    return Corners(tuple(int(n) for n in ids[indices]), fine[indices].astype(np.float64))


def _sides(board: Board, ids: Any, points: Any) -> Array:
    """Distance (n,) px of each corner to the nearest one a unit away on the board; 0: none was found."""
    places = board.places[ids]
    apart = np.abs(places[:, None] - places[None]).sum(axis=2)
    distance = np.linalg.norm(points[:, None] - points[None], axis=2)
    nearest: Array = np.where(np.abs(apart - 1) < 1e-6, distance, np.inf).min(axis=1)
    return np.where(np.isfinite(nearest), nearest, 0.0)
