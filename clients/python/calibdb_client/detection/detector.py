"""Detector of one board: ChArUco, chessboard or AprilGrid."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..board import MIN_CORNERS, Board, opencv
from .aprilgrid import AprilGridFinder
from .corners import Corners, refine

Finder = Callable[[Any], tuple[Any, Any] | None]
"""Finds ids (n,) and coarse points (n, 2) px in a grey picture (h, w)."""


class Detector:
    """Finder of one board in pictures. Raises as `Board.check_opencv` does."""

    def __init__(self, board: Board) -> None:
        self._cv2 = opencv()
        self.board = board
        if board.kind == "aprilgrid":
            self._find: Finder = AprilGridFinder(board)
        elif board.kind == "chessboard":
            self._find = self._chessboard
        else:
            self._charuco_detector = self._cv2.aruco.CharucoDetector(board.opencv())
            self._find = self._charuco

    def find(self, picture: Any) -> Corners | None:
        """Return the corners in a picture (h, w) or (h, w, 3), 8 bits; None if there are too few."""
        grey = grey_of(picture)
        if self.board.inverted:
            grey = self._cv2.bitwise_not(grey)
        found = self._find(grey)
        if found is None or len(found[0]) < MIN_CORNERS:
            return None
        return refine(grey, self.board, *found)

    def _charuco(self, grey: Any) -> tuple[Any, Any] | None:
        points, ids, _, _ = self._charuco_detector.detectBoard(grey)
        if ids is None or len(ids) == 0:
            return None
        return np.asarray(ids).reshape(-1), np.asarray(points, dtype=np.float32).reshape(-1, 2)

    def _chessboard(self, grey: Any) -> tuple[Any, Any] | None:
        columns, rows = (n - 1 for n in self.board.squares)
        found, points = self._cv2.findChessboardCornersSB(grey, (columns, rows))
        if not found:
            return None
        ordered = order_chessboard(grey, np.asarray(points, dtype=np.float32).reshape(rows, columns, 2))
        return np.arange(columns * rows), ordered.reshape(-1, 2)


def grey_of(picture: Any) -> Any:
    """Return a picture (h, w) or (h, w, 3), 8 bits, in shades of grey (h, w)."""
    return picture if picture.ndim == 2 else opencv().cvtColor(picture, opencv().COLOR_BGR2GRAY)


def order_chessboard(grey: Any, lattice: Any) -> Any:
    """Return corners (rows, columns, 2) px as a board held upright has them.

    Not mirrored, with the first square black; of two such orders, the one that begins farther up and left.
    """
    (a, b), (c, d) = lattice[0, -1] - lattice[0, 0], lattice[-1, 0] - lattice[0, 0]
    if a * d - b * c < 0:
        lattice = lattice[:, ::-1]
    turns = [lattice, lattice[::-1, ::-1]]
    if lattice.shape[0] == lattice.shape[1]:
        turns += [np.rot90(each) for each in turns]
    darkness = np.array([_is_dark(grey, each) for each in turns])
    black = [each for each, dark in zip(turns, darkness, strict=True) if dark] or turns
    return min(black, key=lambda each: float(each[0, 0].sum()))


def _is_dark(grey: Any, lattice: Any) -> bool:
    """Whether the square behind the first corner, of the first one's colour, is darker than its neighbour."""
    first, neighbour = lattice[:2, :2].mean(axis=(0, 1)), lattice[:2, 1:3].mean(axis=(0, 1))
    (x, y), (u, v) = np.round([first, neighbour]).astype(int)
    return bool(grey[y, x] < grey[v, u])
