"""AprilGrid in a picture: the tags by cv2.aruco, numbered as Kalibr numbers their corners."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..board import Board, opencv
from ..projection import Array

NEIGHBOURS = 9
"""Tags, itself counted, whose corners tell where a tag's are."""
BORDERS = (2, 1)
"""Cells of black around a tag: Kalibr prints two, OpenCV and the AprilTag library one."""
MIN_CERTAIN_TAGS = 4
"""Tags of one border after which the other is not looked for any more."""


class AprilGridFinder:
    """Finder of the tags of one board, whichever border and whichever way up they were printed."""

    def __init__(self, board: Board) -> None:
        self.board = board
        self._detectors = [tag_detector(board.markers(), border) for border in BORDERS]

    def __call__(self, grey: Any) -> tuple[Any, Any] | None:
        """Return ids (n,) and corners (n, 2) px in a picture (h, w); None if none of its tags is seen."""
        count = self.board.squares[0] * self.board.squares[1]
        found = [find_tags(detector, grey, count) for detector in self._detectors]
        ids, tags = max(found, key=lambda each: len(each[0]))
        if len(ids) >= MIN_CERTAIN_TAGS:  # only this border from now on
            self._detectors = [d for d, each in zip(self._detectors, found, strict=True) if each[0] is ids]
        if len(ids) < 2:
            return None
        corners = (4 * ids[:, None] + np.arange(4)).reshape(-1)
        return corners, self._smooth_corners(ids, self._number_corners(ids, tags)).reshape(-1, 2).astype(
            np.float32
        )

    def _number_corners(self, ids: Any, tags: Array) -> Array:
        """Return the corners (n, 4, 2) px of tags, anticlockwise from the lower left on the upright board.

        Detectors begin with the corner that is first in the tag's code, which prints turn as they like. The
        places of the tags say how the board is turned: a similarity from the board to the picture, without
        mirroring.
        """
        places = self.board.places.reshape(-1, 4, 2)[ids]
        middles, seen = places.mean(axis=1), tags.mean(axis=1)
        a = (middles - middles.mean(axis=0)) @ [1, 1j]
        b = (seen - seen.mean(axis=0)) @ [1, 1j]
        turn = np.vdot(a, b)
        turn /= max(abs(turn), 1e-12)
        expected = ((places - middles[:, None]) @ [1, 1j]) * turn
        # Detectors list corners clockwise, Kalibr anticlockwise.
        given = ((tags - seen[:, None]) @ [1, 1j])[:, ::-1]
        agreement = [float(np.real(np.conj(expected) * np.roll(given, k, axis=1)).sum()) for k in range(4)]
        best = int(np.argmax(agreement))
        return np.roll(tags[:, ::-1], best, axis=1)

    def _smooth_corners(self, ids: Any, tags: Array) -> Array:
        """Return the corners (n, 4, 2) px where the tags around each say that they are.

        Contours run from a tag into the squares that are printed into the corners between tags: single
        corners lie some pixels off, their neighbours' homography does not.
        """
        cv2 = opencv()
        if len(ids) < MIN_CERTAIN_TAGS:
            return tags
        places = self.board.places.reshape(-1, 4, 2)[ids]
        middles = places.mean(axis=1)
        smoothed = tags.copy()
        for n in range(len(ids)):
            near = np.argsort(np.abs(middles - middles[n]).max(axis=1), kind="stable")[:NEIGHBOURS]
            source = (places[near] - middles[n]).reshape(-1, 2)
            matrix, _ = cv2.findHomography(source, tags[near].reshape(-1, 2), cv2.LMEDS)
            if matrix is not None:
                own = (places[n] - middles[n])[None]
                smoothed[n] = cv2.perspectiveTransform(own, matrix)[0]
        return smoothed


def tag_detector(dictionary: Any, border: int) -> Any:
    """Return a detector of tags whose black border is so many cells wide."""
    aruco = opencv().aruco
    parameters = aruco.DetectorParameters()
    parameters.markerBorderBits = border
    return aruco.ArucoDetector(dictionary, parameters)


def find_tags(detector: Any, grey: Any, count: int) -> tuple[Any, Array]:
    """Return ids (n,) below `count`, each once, and corners (n, 4, 2) px, clockwise, of tags in a picture."""
    corners, ids, _ = detector.detectMarkers(grey)
    if ids is None or len(ids) == 0:
        return np.empty(0, dtype=np.int64), np.empty((0, 4, 2))
    numbers = np.asarray(ids).reshape(-1).astype(np.int64)
    values, times = np.unique(numbers, return_counts=True)
    kept = np.isin(numbers, values[times == 1]) & (numbers < count)
    return numbers[kept], np.asarray(corners, dtype=np.float64).reshape(-1, 4, 2)[kept]
