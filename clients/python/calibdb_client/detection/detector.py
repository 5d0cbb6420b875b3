"""Detector of one board: ChArUco, chessboard or AprilGrid."""

from collections.abc import Callable
from typing import Any

import numpy as np

from calibsolver.board import CIRCLES

from ..board import MIN_CORNERS, Board, opencv
from .aprilgrid import AprilGridFinder, without_stray_corners
from .chessboard import find_corners
from .corners import Corners, refine

MIN_COARSE_SIDE_PX = 512
"""Longer side of a shrunk picture in which a chessboard is found, at least."""
MAX_SHRINKING = 3.0
"""Factor by which a picture is shrunk: corners found in a smaller one are too far off to be refined."""
MAX_MISPLACED = 0.4
"""Distance of a circle from its place / distance of neighbours, above which it is another one."""
Finder = Callable[[Any], tuple[Any, Any] | None]
"""Finds ids (n,) and coarse points (n, 2) px in a grey picture (h, w)."""


class Detector:
    """Finder of one board in pictures. Raises MissingPackageError without OpenCV.

    `thorough`: slower detectors look for a chessboard that the first does not find.
    """

    def __init__(self, board: Board, thorough: bool = False) -> None:
        self._cv2 = opencv()
        self.board = board
        self._thorough = thorough
        if board.kind == "aprilgrid":
            self._find: Finder = AprilGridFinder(board)
        elif board.kind == "chessboard":
            self._find = self._chessboard
        elif board.kind in CIRCLES:
            self._find = self._circles
        else:
            self._between_markers, self._next_to_markers = map(self._charuco_detector, (2, 1))
            self._find = self._charuco

    def find_fast(self, picture: Any) -> Corners | None:
        """Return the corners as `find` does, those of a chessboard several times as fast.

        They are found in a shrunk picture and refined in the whole one; blurred ones may be missing.
        """
        grey = grey_of(picture)
        side = max(grey.shape)
        factor = max(MIN_COARSE_SIDE_PX, side / MAX_SHRINKING) / side
        if self.board.kind != "chessboard" or factor >= 1:
            return self.find(grey)
        if self.board.inverted:
            grey = self._cv2.bitwise_not(grey)
        small = self._cv2.resize(grey, None, fx=factor, fy=factor, interpolation=self._cv2.INTER_AREA)
        detection = self._find(small)
        if detection is None:
            return None
        ids, points = detection
        return refine(grey, self.board, ids, (points + 0.5) / factor - 0.5)

    def find(self, picture: Any) -> Corners | None:
        """Return the corners in a picture (h, w) or (h, w, 3), 8 bits; None if there are too few."""
        grey = grey_of(picture)
        if self.board.inverted:
            grey = self._cv2.bitwise_not(grey)
        detection = self._find(grey)
        if detection is None or len(detection[0]) < MIN_CORNERS:
            return None
        if self.board.kind in CIRCLES:
            return Corners(tuple(int(n) for n in detection[0]), detection[1].astype(np.float64))
        corners = refine(grey, self.board, *detection)
        if corners is None or self.board.kind != "aprilgrid":
            return corners
        return without_stray_corners(self.board, corners)

    def _charuco_detector(self, markers: int) -> Any:
        parameters = self._cv2.aruco.CharucoParameters()
        parameters.minMarkers = markers  # next to a corner
        return self._cv2.aruco.CharucoDetector(self.board.opencv(), parameters)

    def _charuco(self, grey: Any) -> tuple[Any, Any] | None:
        """Corners next to a marker: the picture or a finger may cut off the other one.

        Only if a corner lies between two markers, as chance does not put them.
        """
        points, ids, *markers = self._between_markers.detectBoard(grey)
        if ids is None or len(ids) == 0:
            return None
        more_points, more_ids, _, _ = self._next_to_markers.detectBoard(grey, None, None, *markers)
        if more_ids is not None:  # else the homographies of single markers contradict one another
            points, ids = more_points, more_ids
        return np.asarray(ids).reshape(-1), np.asarray(points, dtype=np.float32).reshape(-1, 2)

    def _circles(self, grey: Any) -> tuple[Any, Any] | None:
        cv2 = self._cv2
        kind = cv2.CALIB_CB_SYMMETRIC_GRID
        if self.board.kind == "asymmetric_circles":
            kind = cv2.CALIB_CB_ASYMMETRIC_GRID
        for flags in (kind, kind | cv2.CALIB_CB_CLUSTERING):
            is_there, points = cv2.findCirclesGrid(grey, self.board.squares, flags=flags)
            if is_there:
                points = np.asarray(points).reshape(-1, 2)
                placed = np.flatnonzero(self._misplaced(points) < MAX_MISPLACED)
                return placed, points[placed]
        return None

    def _misplaced(self, points: Any) -> Any:
        """Distance (n,) of points from their places on the board / distance of neighbours.

        OpenCV 4.10 takes circles of another column for those of the first now and then.
        """
        board = self.board.points[:, :2].astype(np.float32)
        homography, _ = self._cv2.findHomography(board, points, self._cv2.LMEDS)
        if homography is None:
            return np.full(len(points), np.inf)
        expected = self._cv2.perspectiveTransform(board[None], homography)[0]
        spacing = np.median(np.linalg.norm(np.diff(points, axis=0), axis=1))
        return np.linalg.norm(expected - points, axis=1) / spacing

    def _chessboard(self, grey: Any) -> tuple[Any, Any] | None:
        columns, rows = (n - 1 for n in self.board.squares)
        lattice = find_corners(grey, (columns, rows), self._thorough)
        if lattice is None:
            return None
        ordered = _order_chessboard(grey, lattice)
        return np.arange(columns * rows), ordered.reshape(-1, 2)


def grey_of(picture: Any) -> Any:
    """Return a picture (h, w) or (h, w, 3), 8 bits, in shades of grey (h, w)."""
    return picture if picture.ndim == 2 else opencv().cvtColor(picture, opencv().COLOR_BGR2GRAY)


def _order_chessboard(grey: Any, lattice: Any) -> Any:
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
    """True if the square behind the first corner, of the first one's colour, is darker than its neighbour."""
    first, neighbour = lattice[:2, :2].mean(axis=(0, 1)), lattice[:2, 1:3].mean(axis=(0, 1))
    (x, y), (u, v) = np.round([first, neighbour]).astype(int)
    return bool(grey[y, x] < grey[v, u])
