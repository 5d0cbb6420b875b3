"""Boards in drawn pictures, whose corners are known, and in real photographs and videos of CALIBDB_DATA."""

from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from calibdb_client import Board
from calibdb_client.capture.video import board_in_video, read_video
from calibdb_client.detection import Detector, recognise
from calibdb_client.errors import CaptureError, MirroredError
from calibdb_client.pictures import FoundViews, picture_paths, read, recognise_board
from calibsolver import fit
from tests.helpers import board_pictures
from tests.helpers.data import data_dir, external_data
from tests.helpers.marks import thorough

KINDS = (
    Board(),
    Board((8, 8), 0.75, "DICT_5X5_50", inverted=True),
    Board((6, 8), 0.5, legacy=True),
    Board((9, 6), kind="chessboard"),
    Board((8, 8), kind="chessboard"),
    Board((6, 4), kind="aprilgrid"),
    Board((4, 3), kind="aprilgrid", tag_spacing=0.5, inverted=True),
)
UNUSUAL = replace(KINDS[6], tag_spacing=0.43)
TILTS = board_pictures.TILTS[:2]
DISTANCE = 1.2  # sides of the board


def drawn(board: Board, tilt: tuple[float, float, float] = TILTS[0]) -> np.ndarray:
    return board_pictures.picture(board, tilt, DISTANCE * max(board.size))


@pytest.mark.parametrize("board", KINDS, ids=str)
def test_corners_of_every_kind_are_where_they_were_drawn(board: Board) -> None:
    assert Board(**board.record()) == board
    distance = DISTANCE * max(board.size)
    bound = 0.3 if board.kind == "aprilgrid" else 0.1  # a tag's outer corner has no second edge to hold it
    for tilt in TILTS:
        found = Detector(board).find(drawn(board, tilt))
        assert found is not None
        assert len(found.ids) > 0.6 * board.corner_count
        expected = board_pictures.corners(board, tilt, (0, 0, distance))[list(found.ids)]
        off = np.linalg.norm(found.points - expected, axis=1)
        assert np.sqrt(np.mean(off**2)) < bound
        assert off.max() < 0.6
    assert Detector(board).find(np.full((480, 640), 128, np.uint8)) is None


@pytest.mark.parametrize("inverted", [False, True])
def test_chessboard_found_in_a_shrunk_picture_has_the_same_corners(inverted: bool) -> None:
    board = Board((9, 6), kind="chessboard", inverted=inverted)
    picture = cv2.resize(board_pictures.picture(board, TILTS[0], 12), None, fx=2, fy=2)
    detector = Detector(board)
    exact, fast = detector.find(picture), detector.find_fast(picture)
    assert exact is not None
    assert fast is not None
    assert fast.ids == exact.ids
    assert np.abs(fast.points - exact.points).max() < 0.05


@pytest.mark.parametrize(
    "board",
    [*KINDS[1:4], UNUSUAL, *thorough(KINDS[6], *(replace(UNUSUAL, tag_spacing=gap) for gap in (0.2, 0.25)))],
    ids=str,
)
def test_board_of_every_kind_is_recognised(board: Board) -> None:
    tilts = TILTS if board.kind == "aprilgrid" else TILTS[:1]
    found = recognise([drawn(board, tilt) for tilt in tilts])
    assert found is not None
    assert found.tag_spacing == pytest.approx(board.tag_spacing, abs=0.005)
    assert replace(found, tag_spacing=board.tag_spacing) == board


def test_kalibrs_tags_have_a_wider_border_and_another_turn() -> None:
    board = Board((4, 3), kind="aprilgrid")
    picture = np.full((500, 640), 255, dtype=np.uint8)
    side, pitch, top = 100, 130, 440
    for tag in range(12):
        row, column = divmod(tag, 4)
        drawn = cv2.aruco.generateImageMarker(board.markers(), tag, side, borderBits=2)
        x, y = 60 + column * pitch, top - row * pitch - side
        picture[y : y + side, x : x + side] = drawn[::-1, ::-1]
    found = Detector(board).find(cv2.GaussianBlur(picture, (0, 0), 1.0))
    assert found is not None
    assert len(found.ids) == 48
    expected = board.places[list(found.ids)] * side + [59.5, top - 0.5]
    assert np.linalg.norm(found.points - expected, axis=1).max() < 0.6
    recognised = recognise([picture])
    assert recognised is not None
    assert (recognised.kind, recognised.squares, recognised.tag_spacing) == ("aprilgrid", (4, 3), 0.3)


@pytest.mark.parametrize(
    ("board", "inverted"),
    [(KINDS[0], True), *thorough((KINDS[0], False), (KINDS[1], True), (KINDS[1], False))],
)
def test_mirrored_pictures_are_recognised_as_mirrored(board: Board, inverted: bool) -> None:
    shown = replace(board, inverted=inverted)
    pictures = [drawn(shown)[:, ::-1]]
    with pytest.raises(MirroredError, match="--mirrored"):
        recognise(pictures)
    assert recognise(pictures, mirrored=True) == shown


def test_partly_hidden_markers_suffice() -> None:
    """Half of a board is covered in each picture, another half each time."""
    board = Board((9, 6))
    pictures = []
    for n, tilt in enumerate(TILTS):
        picture = drawn(board, tilt).copy()
        w = picture.shape[1]
        picture[:, : w // 2 if n % 2 else 0] = 128
        picture[:, w if n % 2 else w // 2 :] = 128
        pictures.append(picture)
    assert recognise(pictures) == board


def test_corners_between_two_markers_stay_where_single_markers_contradict(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """OpenCV then returns no corner: None instead of arrays."""
    picture = drawn(Board())
    detector = Detector(Board())
    whole = detector.find(picture)
    nothing = SimpleNamespace(detectBoard=lambda *_: (None, None, (), None))
    monkeypatch.setattr(detector, "_next_to_markers", nothing)
    found = detector.find(picture)
    assert whole is not None
    assert found is not None
    assert set(found.ids) <= set(whole.ids)
    assert len(found.ids) > 0.6 * Board().corner_count


def test_chessboard_on_which_pictures_differ_is_asked_for() -> None:
    boards = [Board(squares, kind="chessboard") for squares in ((7, 6), (7, 5))]
    pictures = [
        cv2.resize(drawn(board, tilt), (320, 240), interpolation=cv2.INTER_AREA)
        for board in boards
        for tilt in TILTS
    ]
    with pytest.raises(CaptureError, match=r"7x6 or 7x5 squares.*Count its squares"):
        recognise(pictures)


def test_nothing_is_recognised_in_a_picture_of_nothing() -> None:
    noise = np.random.default_rng(0).integers(0, 255, (240, 320), dtype=np.uint8)
    assert recognise([np.full((240, 320), 128, dtype=np.uint8), cv2.GaussianBlur(noise, (0, 0), 3)]) is None
    assert recognise([]) is None


@external_data
@pytest.mark.parametrize(
    ("name", "squares", "count"),
    thorough(
        ("arizonat_fe", (8, 6), 10),
        ("mint_isaw", (11, 8), 14),
        ("picam_640", (8, 8), 25),
        ("omnidir_left", (9, 7), 12),
        ("omnidir_right", (9, 7), 12),
    ),
)
def test_every_chessboard_in_real_photographs_is_recognised_and_detected(
    name: str, squares: tuple[int, int], count: int
) -> None:
    paths = picture_paths([data_dir() / "photos" / f"chessboard_{name}"])
    board = recognise_board(paths)
    assert board == Board(squares, kind="chessboard")
    result = FoundViews()
    read(paths, board, result)
    assert len(result.views) == len(paths) == count
    assert min(len(view.ids) for _, view in result.views) == board.corner_count


@external_data
@pytest.mark.thorough
def test_spacing_of_an_aprilgrid_is_found_behind_a_fisheye() -> None:
    """TUM-VI: printed with spacing 0.3; published focal length 382 px."""
    paths = picture_paths([data_dir() / "photos" / "aprilgrid_tumvi"])
    board = recognise_board(paths)
    assert board == Board((6, 6), kind="aprilgrid")
    assert board.tag_spacing == 0.3
    result = FoundViews()
    read(paths, board, result)
    views = list(board.views(view.record() for _, view in result.views))
    calibration = fit(views, (1024, 1024), "fisheye")
    assert len(views) == 5
    assert not calibration.cut_views
    assert calibration.camera.matrix[0, 0] == pytest.approx(382, rel=0.01)


def test_spacing_on_which_pictures_disagree_is_refused() -> None:
    boards = [Board((4, 3), kind="aprilgrid", tag_spacing=spacing) for spacing in (0.2, 0.5)]
    assert recognise([board_pictures.picture(board, TILTS[0], 8.5) for board in boards]) is None


WHITE_ON_BLACK = Board((4, 5), 0.75, inverted=True)
VIDEOS = {
    "caliscope_opt1.mp4": WHITE_ON_BLACK,
    "caliscope_opt1_mpeg4.mp4": WHITE_ON_BLACK,
    "caliscope_char0_mpeg4.mp4": WHITE_ON_BLACK,
    "chessboard_yubin.mp4": Board((9, 7), kind="chessboard"),
    "chessboard_uk.avi": Board((11, 8), kind="chessboard"),
}
FASTEST = "caliscope_char0_mpeg4.mp4"


@external_data
@pytest.mark.parametrize("name", [FASTEST, *thorough(*(name for name in VIDEOS if name != FASTEST))])
def test_board_of_a_real_video_is_recognised(name: str) -> None:
    assert board_in_video(data_dir() / "videos" / name) == VIDEOS[name]


@external_data
@pytest.mark.thorough
def test_mirrored_video_is_recognised_and_turned_back() -> None:
    path = data_dir() / "videos" / "caliscope_pre1_mirrored.mp4"
    with pytest.raises(MirroredError):
        board_in_video(path)
    found = FoundViews()
    assert read_video(path, None, found, mirrored=True) == WHITE_ON_BLACK
    assert found.frames > 40
    size, views = found.of_one_size()
    assert size == (1280, 720)
    assert len(views) == 4, "the other frames show poses that are too alike"
