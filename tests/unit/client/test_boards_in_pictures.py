"""Boards in drawn pictures, whose corners are known: found to a fraction of a pixel, and recognised."""

import cv2
import numpy as np
import pytest

from calibdb_client import Board, UsageError
from calibdb_client.detection import Detector, recognise
from calibsolver import Board as SolverBoard
from tests.helpers import board_pictures

KINDS = (
    Board(),
    Board((8, 8), 0.75, "DICT_5X5_50", inverted=True),
    Board((6, 8), 0.5, legacy=True),
    Board((9, 6), kind="chessboard"),
    Board((8, 8), kind="chessboard"),
    Board((6, 4), kind="aprilgrid"),
    Board((5, 5), kind="aprilgrid", tag_spacing=0.5, inverted=True),
)
TILTS = board_pictures.TILTS[:3]


def truth(
    board: Board, tilt: tuple[float, float, float], ids: tuple[int, ...], distance: float
) -> np.ndarray:
    """Pixels (n, 2) of the corners."""
    points = np.column_stack([board.places[list(ids)], np.zeros(len(ids))])
    rotation = cv2.Rodrigues(np.array(tilt))[0]
    tvec = np.array([0, 0, distance]) - rotation @ [*board.edge.mean(axis=0), 0]
    return cv2.projectPoints(points, np.array(tilt), tvec, board_pictures.MATRIX, None)[0][:, 0]


@pytest.mark.parametrize("board", KINDS, ids=str)
def test_corners_of_every_kind_are_where_they_were_drawn(board: Board) -> None:
    distance = 1.2 * max(board.size)
    bound = 0.3 if board.kind == "aprilgrid" else 0.1  # a tag's outer corner has no second edge to hold it
    for tilt in TILTS[:2]:
        found = Detector(board).find(board_pictures.picture(board, tilt, distance))
        assert found is not None
        assert len(found.ids) > 0.6 * board.corner_count
        off = np.linalg.norm(found.points - truth(board, tilt, found.ids, distance), axis=1)
        assert np.sqrt(np.mean(off**2)) < bound
        assert off.max() < 0.6


@pytest.mark.parametrize("board", [KINDS[i] for i in (0, 1, 2, 3, 6)], ids=str)
def test_board_of_every_kind_is_recognised(board: Board) -> None:
    pictures = [board_pictures.picture(board, tilt, 1.2 * max(board.size)) for tilt in TILTS]
    found = recognise(pictures)
    assert found is not None
    assert abs(found.marker_ratio - board.marker_ratio) < 0.02
    assert Board(**{**vars_of(found), "marker_ratio": board.marker_ratio}) == board


def vars_of(board: Board) -> dict[str, object]:
    names = ("squares", "marker_ratio", "dictionary", "legacy", "kind", "inverted", "tag_spacing")
    return {name: getattr(board, name) for name in names}


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


def test_nothing_is_recognised_in_a_picture_of_nothing() -> None:
    noise = np.random.default_rng(0).integers(0, 255, (240, 320), dtype=np.uint8)
    assert recognise([np.full((240, 320), 128, dtype=np.uint8), cv2.GaussianBlur(noise, (0, 0), 3)]) is None
    assert recognise([]) is None


@pytest.mark.parametrize("board", KINDS, ids=str)
def test_corners_are_numbered_as_the_solver_numbers_them(board: Board) -> None:
    solver = SolverBoard.from_record(board.record())
    assert np.array_equal(board.places, solver.points[:, :2])
    assert np.allclose(board.edge, solver.outline[:, :2])
    assert board.size == solver.size


@pytest.mark.parametrize(
    "wrong",
    [
        {"kind": "aprilgrid", "squares": (1, 1)},
        {"kind": "aprilgrid", "dictionary": "DICT_4X4_50"},
        {"kind": "aprilgrid", "tag_spacing": 3.0},
        {"kind": "circles"},
    ],
)
def test_board_of_a_kind_that_cannot_exist_is_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(UsageError):
        Board(**wrong)
