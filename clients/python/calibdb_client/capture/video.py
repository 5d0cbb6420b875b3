"""A recorded video: which of its frames become views."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..board import Board
from ..detection import Corners, Detector, recognise
from ..detection.recognition import MAX_LOOKED_AT
from ..errors import CaptureError
from ..pictures import FoundViews
from ..recording import RecordedView
from .source import open_source
from .stillness import REFERENCE_WIDTH_PX, motion

MAX_FRAMES = 600
"""Frames in which the board is looked for; of longer videos as many, spread evenly."""
MAX_VIDEO_VIEWS = 60
MIN_APART_PX = 30.0
"""Distance between two views, at 1280 px image width, mean over the corners."""
_POSITION, _COUNT = 1, 7  # of cv2.VideoCapture


def read_video(
    path: str | Path,
    board: Board | None,
    found: FoundViews,
    progress: Callable[[int, int], None] | None = None,
) -> Board:
    """Find the board in a video, and add to `found` the views where it moves least, all over its places.

    Returns the board, which is recognised unless it is given. Raises UsageError if the file is no video,
    CaptureError if no board is recognised.
    """
    chosen = board or board_in_video(path)
    detector = Detector(chosen)
    opened = open_source(path)
    seen: list[tuple[int, tuple[int, int], Corners]] = []
    try:
        capture = opened.source
        count = max(int(capture.get(_COUNT)), 0)
        step = max(1, -(-count // MAX_FRAMES))
        number = -1
        while len(seen) < MAX_FRAMES and capture.grab():
            number += 1
            if number % step:
                continue
            there, picture = capture.retrieve()
            if not there or picture is None:
                continue
            corners = detector.find(picture)
            if corners is not None:
                h, w = picture.shape[:2]
                seen.append((number, (int(w), int(h)), corners))
            if progress:
                progress(number + 1, max(count, number + 1))
        if number < 0:
            raise CaptureError(
                f"{path} holds no picture: it is corrupt, or of a kind that OpenCV cannot read"
            )
        if 0 <= number < 0.9 * count - 1:
            found.broken = f"{path} breaks off after {number + 1} of {count} frames: those before it are used"
    finally:
        opened.close()
        _choose(seen, step=step if seen else 1, found=found)
    return chosen


def _choose(seen: list[tuple[int, tuple[int, int], Corners]], step: int, found: FoundViews) -> None:
    """Add the stillest views first, each at a distance from those before it, in the video's order."""
    motions: list[float] = []
    for i, (number, _, corners) in enumerate(seen):
        near = [each for each in seen[max(i - 1, 0) : i + 2] if 0 < abs(each[0] - number) <= step]
        motions.append(max((motion(corners, each[2]) for each in near), default=float("inf")))
    chosen: list[int] = []
    for i in sorted(range(len(seen)), key=lambda each: motions[each]):
        apart = MIN_APART_PX * seen[i][1][0] / REFERENCE_WIDTH_PX
        if all(motion(seen[i][2], seen[k][2]) > apart for k in chosen):
            chosen.append(i)
        if len(chosen) == MAX_VIDEO_VIEWS:
            break
    for i in sorted(chosen):
        number, size, corners = seen[i]
        points = tuple((float(u), float(v)) for u, v in corners.points.tolist())
        found.views.append((size, RecordedView(f"frame {number + 1}", corners.ids, points)))


def board_in_video(path: str | Path) -> Board:
    """Return the board that frames all over a video show. Raises as `read_video` does."""
    opened = open_source(path)
    pictures: list[Any] = []
    try:
        capture = opened.source
        count = int(capture.get(_COUNT))
        for n in range(MAX_LOOKED_AT):
            if count > MAX_LOOKED_AT:
                capture.set(_POSITION, n * count // MAX_LOOKED_AT)
            there, picture = capture.read()
            if there and picture is not None:
                pictures.append(picture)
    finally:
        opened.close()
    board = recognise(pictures)
    if board is None:
        raise CaptureError(
            f"no board was recognised in {path}: describe it by --kind, --squares, --marker-ratio and "
            "--dictionary"
            if pictures
            else f"{path} holds no picture: it is corrupt, or of a kind that OpenCV cannot read"
        )
    return board
