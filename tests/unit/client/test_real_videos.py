"""Recognition in real videos, which are read where CALIBDB_DATA has them."""

import pytest

from calibdb_client import Board
from calibdb_client.capture.video import board_in_video, read_video
from calibdb_client.errors import MirroredError
from calibdb_client.pictures import FoundViews
from tests.helpers.data import data_dir, external_data
from tests.helpers.marks import thorough

pytestmark = external_data

WHITE_ON_BLACK = Board((4, 5), 0.75, inverted=True)
BOARDS = {
    "caliscope_opt1.mp4": WHITE_ON_BLACK,
    "caliscope_opt1_mpeg4.mp4": WHITE_ON_BLACK,
    "caliscope_char0_mpeg4.mp4": WHITE_ON_BLACK,
    "chessboard_yubin.mp4": Board((9, 7), kind="chessboard"),
    "chessboard_uk.avi": Board((11, 8), kind="chessboard"),
}
FASTEST = "caliscope_char0_mpeg4.mp4"
VIDEO = "videos"


@pytest.mark.parametrize("name", [FASTEST, *thorough(*(name for name in BOARDS if name != FASTEST))])
def test_board_of_a_real_video_is_recognised(name: str) -> None:
    assert board_in_video(data_dir() / VIDEO / name) == BOARDS[name]


@pytest.mark.thorough
def test_mirrored_video_is_recognised_and_turned_back() -> None:
    path = data_dir() / VIDEO / "caliscope_pre1_mirrored.mp4"
    with pytest.raises(MirroredError):
        board_in_video(path)
    found = FoundViews()
    assert read_video(path, None, found, mirrored=True) == WHITE_ON_BLACK
    assert found.frames > 40
    size, views = found.of_one_size()
    assert size == (1280, 720)
    assert len(views) == 4, "the other frames show poses that are too alike"
