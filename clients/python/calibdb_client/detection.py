"""Corners of a ChArUco board in a picture, by OpenCV; the picture goes nowhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .board import Board
from .projection import Array

MIN_CORNERS = 6
"""Corners of a view that the service can judge."""
MIN_SQUARE_PX = 12.0
"""Side of a square in the picture; corners of smaller ones are not measured well."""
MAX_REFINEMENT_PX = 2.0
"""Distance by which refinement may move a corner; one that it moves farther is no corner."""
_STEPS = (3, 40, 0.001)  # by count and by change, iterations, px


@dataclass(frozen=True, eq=False)
class Corners:
    """Corners found in one picture.

    Attributes
    ----------
    ids
        (n,) numbers of the corners.
    points
        (n, 2) px.
    """

    ids: tuple[int, ...]
    points: Array


class Detector:
    """Finds one board in pictures. Raises as `Board.opencv` does."""

    def __init__(self, board: Board) -> None:
        import cv2

        self._cv2 = cv2
        self._columns = board.squares[0] - 1
        self._detector = cv2.aruco.CharucoDetector(board.opencv())

    def find(self, picture: Any) -> Corners | None:
        """Return the corners in a picture (h, w) or (h, w, 3), 8 bits; None if there are too few."""
        cv2 = self._cv2
        grey = picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        points, ids, _, _ = self._detector.detectBoard(grey)
        if ids is None or len(ids) < MIN_CORNERS:
            return None
        numbers = np.asarray(ids).reshape(-1)
        coarse = np.asarray(points, dtype=np.float32).reshape(-1, 2)
        sides = self._sides(numbers, coarse)
        fine = coarse.copy()
        for n, side in enumerate(sides):
            # A window that holds no other edge than those that meet in the corner
            half = int(np.clip(round(side / 8), 2, 6))
            cv2.cornerSubPix(grey, fine[n : n + 1], (half, half), (-1, -1), _STEPS)
        moved = np.linalg.norm(fine - coarse, axis=1)
        kept = np.flatnonzero((sides >= MIN_SQUARE_PX) & (moved <= MAX_REFINEMENT_PX))
        if len(kept) < MIN_CORNERS:
            return None
        return Corners(tuple(int(n) for n in numbers[kept]), fine[kept].astype(np.float64))

    def _sides(self, ids: Any, points: Any) -> Array:
        """Distance (n,) of each corner to its nearest neighbour on the board, px; 0 if none was found."""
        places = {int(n): points[i] for i, n in enumerate(ids)}
        sides = np.zeros(len(ids))
        for i, number in enumerate(ids):
            column = int(number) % self._columns
            neighbours = [number - self._columns, number + self._columns]
            neighbours += [number - 1] if column > 0 else []
            neighbours += [number + 1] if column + 1 < self._columns else []
            found = [
                float(np.linalg.norm(points[i] - places[int(n)])) for n in neighbours if int(n) in places
            ]
            sides[i] = min(found, default=0.0)
        return sides
