"""Detection in videos by the Python client: chessboards against ChArUco boards, real footage."""

import time
from collections.abc import Iterator

from calibdb_client.capture.video import read_video
from calibdb_client.pictures import FoundViews
from tests.bench.table import Row
from tests.helpers import data

CHARUCO, CHESSBOARD = "caliscope_opt1.mp4", "chessboard_yubin.mp4"
LENGTHS = {CHARUCO: 57 / 6, CHESSBOARD: 260 / 24}
"""s; the camera of the first took 6 frames/s."""
ROUNDS = 3


def rows() -> Iterator[Row]:
    """Processor time per second of video, the least of some rounds in turn."""
    if data.EXTERNAL is None:  # licences keep the videos out of `tests/data`
        return
    taken = {
        name: min(seconds)
        for name, seconds in zip(LENGTHS, zip(*map(once, range(ROUNDS)), strict=True), strict=True)
    }
    note = ", ".join(f"{name} {value:.2f} s/s" for name, value in taken.items())
    yield Row("video of a chessboard / of a ChArUco board", taken[CHESSBOARD] / taken[CHARUCO], 2, "x", note)


def once(_round: int) -> list[float]:
    """Processor time of each video / its length."""
    shares = []
    for name, length in LENGTHS.items():
        begun = time.process_time()
        read_video(data.data_dir() / "videos" / name, None, FoundViews())
        shares.append((time.process_time() - begun) / length)
    return shares
