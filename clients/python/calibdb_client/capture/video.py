"""Views of a recorded video."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..board import DESCRIBE_IT, Board, opencv
from ..detection import Corners, Detector, recognise
from ..detection.recognition import MAX_LOOKED_AT
from ..errors import CaptureError
from ..pictures import FoundViews
from ..recording import Progress, RecordedView
from .source import open_source
from .stillness import REFERENCE_WIDTH_PX, motion

MAX_FRAMES = 600
"""Frames in which the board is looked for; of longer videos as many, spread evenly."""
MAX_VIDEO_VIEWS = 60
MIN_APART_PX = 30.0
"""Distance between two views, at 1280 px image width, mean over the corners."""
SLOW_FRAMES_PER_S = 8.0
"""Frames of a second in which a chessboard is looked for: it takes longer to find than markers."""
_POSITION, _FRAMES_PER_S, _COUNT = 1, 5, 7  # of cv2.VideoCapture
NO_IMAGE = "{} contains no image: it is corrupt, or of a kind that OpenCV cannot read"
Seen = tuple[int, tuple[int, int], Corners]
"""Number of a frame, its size (w, h) px, and the corners in it."""


def read_video(
    path: str | Path,
    board: Board | None,
    board_views: FoundViews,
    progress: Progress | None = None,
    mirrored: bool = False,
) -> Board:
    """Find the board in a video; add the views in which it moves least, at many places, to `board_views`.

    Returns the board, which is recognised by default. A `mirrored` video is turned back. Raises UsageError if
    the file is not a video, CaptureError if no board is recognised.
    """
    chosen = board or board_in_video(path, mirrored)
    detector = Detector(chosen)
    observations: list[Seen] = []
    numbers: list[int] = []
    try:
        rate = SLOW_FRAMES_PER_S if chosen.kind == "chessboard" else float("inf")
        for number, count, picture in _pictures(path, board_views, mirrored, rate):
            numbers.append(number)
            corners = detector.find_fast(picture)
            if corners is not None:
                h, w = picture.shape[:2]
                observations.append((number, (int(w), int(h)), corners))
            if progress:
                progress(number + 1, max(count, number + 1))
    finally:
        board_views.frames = len(observations)
        for number, size, corners in _choose(observations, numbers[1] if len(numbers) > 1 else 1):
            board_views.views.append((size, RecordedView.of(f"frame {number + 1}", corners)))
    return chosen


def _pictures(
    path: str | Path, board_views: FoundViews, mirrored: bool, rate: float
) -> Iterator[tuple[int, int, Any]]:
    """Yield number, count and picture of the frames of a video that are looked at."""
    opened = open_source(path)
    try:
        capture = opened.source
        count = max(int(capture.get(_COUNT)), 0)
        step = max(1, -(-count // MAX_FRAMES), int(capture.get(_FRAMES_PER_S) / rate))
        number, looked_at = -1, 0
        while looked_at < MAX_FRAMES and capture.grab():
            number += 1
            if number % step:
                continue
            there, picture = capture.retrieve()
            if not there or picture is None:
                continue
            looked_at += 1
            yield number, count, opencv().flip(picture, 1) if mirrored else picture
        if number < 0:
            raise CaptureError(NO_IMAGE.format(path))
        if looked_at < MAX_FRAMES and 0 <= number < 0.9 * count - 1:
            board_views.broken = (
                f"{path} breaks off after {number + 1} of {count} frames: those before it are used"
            )
    finally:
        opened.close()


def _choose(seen: list[Seen], step: int) -> list[Seen]:
    """Return the stillest views first, each at a distance from those before it, in the video's order."""
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
    return [seen[i] for i in sorted(chosen)]


def board_in_video(path: str | Path, mirrored: bool = False) -> Board:
    """Return the board that frames all over a video show. Parameters and errors as of `read_video`."""
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
    board = recognise(pictures, mirrored)
    if board is None:
        if not pictures:
            raise CaptureError(NO_IMAGE.format(path))
        raise CaptureError(f"no board was recognised in {path}: {DESCRIBE_IT}")
    return board
