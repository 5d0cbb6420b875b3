"""Chessboards in pictures, by OpenCV's detectors one after the other, and the number of their corners."""

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..board import opencv
from ..errors import CaptureError
from .corners import STEPS

MAX_COUNTED = 6
MAX_CANDIDATES = 4
"""Sizes of a board that are tried, those that most corners speak for."""
MIN_AGREEMENT = 0.6
"""Share of the pictures that agree on the number of corners; below, the user has to count the squares."""


def find_corners(grey: Any, size: tuple[int, int], thorough: bool = True) -> Any | None:
    """Return the corners (rows, columns, 2) px of a chessboard in a picture (h, w); None if it is not seen.

    By the sector-based detector; if `thorough` then on the normalised picture and exhaustively, and by the
    classic one (Duda & Frese, BMVC 2018; OpenCV's documentation): each finds boards that the others miss.
    `size`: columns and rows of corners.
    """
    cv2 = opencv()
    columns, rows = size
    exhaustive = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE
    for flags in (0, exhaustive) if thorough else (0,):
        is_there, points = cv2.findChessboardCornersSB(grey, size, flags=flags)
        if is_there:
            return np.asarray(points, dtype=np.float32).reshape(rows, columns, 2)
    if not thorough:
        return None
    is_there, points = cv2.findChessboardCorners(grey, size)
    if not is_there:
        return None
    coarse = np.ascontiguousarray(points, dtype=np.float32).reshape(-1, 1, 2)
    return cv2.cornerSubPix(grey, coarse, (3, 3), (-1, -1), STEPS).reshape(rows, columns, 2)


def count_corners(greys: Sequence[Any]) -> tuple[int, int] | None:
    """Return the columns and rows of corners, the larger first, of the chessboard in pictures (h, w).

    None if fewer than two pictures, or the only one, show it. Raises CaptureError if pictures differ on the
    number: part of the board may be out of them.
    """
    cv2 = opencv()
    chosen = list(greys)
    if len(chosen) > MAX_COUNTED:
        chosen = [chosen[n * len(chosen) // MAX_COUNTED] for n in range(MAX_COUNTED)]
    votes: Counter[tuple[int, int]] = Counter()
    for flags in (0, cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE):
        counted: Counter[tuple[int, int]] = Counter()
        for grey in chosen:
            is_there, _, meta = cv2.findChessboardCornersSBWithMeta(grey, (3, 3), cv2.CALIB_CB_LARGER | flags)
            if is_there and meta is not None:
                a, b = np.asarray(meta).shape[:2]
                counted[max(a, b), min(a, b)] += 1
        if counted:
            size, count = counted.most_common(1)[0]
            if 2 * count > len(chosen) and count >= MIN_AGREEMENT * counted.total():
                return size
        votes += counted
    # Parts of a board are also found: the largest size in the images is the board's.
    sizes = sorted(votes, key=lambda size: -votes[size] * size[0] * size[1])[:MAX_CANDIDATES]
    shown = [[size for size in sizes if find_corners(grey, size) is not None] for grey in chosen]
    scores = Counter(size for there in shown for size in there)
    often = [size for size in sizes if scores[size] >= min(2, len(chosen))]
    best = max(often, key=lambda size: scores[size] * size[0] * size[1], default=None)
    if best is not None and len(often) > 1 and scores[best] < MIN_AGREEMENT * sum(map(bool, shown)):
        names = " or ".join(f"{columns + 1}x{rows + 1}" for columns, rows in often)
        raise CaptureError(
            f"a chessboard of {names} squares, as the pictures have it: part of it may be outside of them. "
            "Count its squares, and pass --kind chessboard --squares CxR"
        )
    return best
