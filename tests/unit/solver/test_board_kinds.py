"""Chessboards, AprilGrids and inverted boards."""

import cv2
import numpy as np
import pytest

from calibsolver import Board, View, fit
from calibsolver.guidance.overlay import draw_board
from tests.helpers.solver.export_sources import captured, truth

APRILGRID = Board(kind="aprilgrid", squares=(6, 5), dictionary="DICT_APRILTAG_36h11", tag_spacing=0.3)
CHESSBOARD = Board(kind="chessboard", squares=(10, 7))


def test_chessboard_has_inner_corners_row_by_row() -> None:
    assert Board(kind="chessboard", squares=(60, 40)).corner_count == 59 * 39  # without markers
    assert CHESSBOARD.corner_count == len(CHESSBOARD.points) == 9 * 6
    np.testing.assert_array_equal(
        CHESSBOARD.points[[0, 8, 9, 53]], [[1, 1, 0], [9, 1, 0], [1, 2, 0], [9, 6, 0]]
    )


def test_aprilgrid_is_numbered_as_by_kalibr() -> None:
    assert APRILGRID.corner_count == len(APRILGRID.points) == 4 * 30
    assert APRILGRID.size == pytest.approx((6 + 5 * 0.3, 5 + 4 * 0.3))
    np.testing.assert_allclose(APRILGRID.points[:4], [[0, 0, 0], [1, 0, 0], [1, -1, 0], [0, -1, 0]])
    np.testing.assert_allclose(APRILGRID.points[4 * 1], [1.3, 0, 0])
    np.testing.assert_allclose(APRILGRID.points[4 * 6 + 2], [1, -2.3, 0])
    lattice = APRILGRID.lattice
    assert lattice[-1, :4].tolist() == [0, 1, 4, 5]
    assert lattice[0, 0] == 4 * 24 + 3
    xy = APRILGRID.points[lattice]
    assert (np.diff(xy[..., 0], axis=1) > 0).all()
    assert (np.diff(xy[..., 1], axis=0) > 0).all()
    low, high = APRILGRID.outline.min(axis=0), APRILGRID.outline.max(axis=0)
    assert ((APRILGRID.points >= low) & (APRILGRID.points <= high)).all()


SIDE, BORDER = 80, 60  # px


def detected(board: Board) -> tuple[np.ndarray, np.ndarray]:
    """Ids (n,) and corners (n, 4, 2) of the markers that OpenCV finds on a drawn board, board units."""
    border = [BORDER] * 4
    picture = cv2.copyMakeBorder(draw_board(board, SIDE), *border, cv2.BORDER_CONSTANT, value=255)
    parameters = cv2.aruco.DetectorParameters()
    parameters.markerBorderBits = 2 if board.kind == "aprilgrid" else 1
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    corners, ids, _ = cv2.aruco.ArucoDetector(dictionary, parameters).detectMarkers(picture)
    places = (np.concatenate(corners) - BORDER + 0.5) / SIDE + board.outline[0, :2]
    return ids.ravel(), places


@pytest.mark.parametrize(
    "board", [Board((5, 4)), Board((4, 6), legacy=True), Board((4, 5), legacy=True), APRILGRID], ids=repr
)
def test_support_of_a_corner_is_the_markers_beside_it(board: Board) -> None:
    """OpenCV finds a marker at each group of four points."""
    drawn = detected(board)[1].mean(axis=1)
    expected = board.support[..., :2].mean(axis=2)
    nearest = np.linalg.norm(expected[:, :, None] - drawn, axis=-1).min(axis=2)
    assert nearest.max() < 2 / SIDE


def test_drawn_aprilgrid_is_found_where_its_corners_are() -> None:
    """OpenCV names corners clockwise from the upper left."""
    ids, corners = detected(APRILGRID)
    assert sorted(ids.tolist()) == list(range(30))
    expected = APRILGRID.points[4 * ids[:, None] + [3, 2, 1, 0], :2]
    assert np.abs(corners - expected).max() < 3 / SIDE


def test_half_turn_leaves_a_chessboard_of_equal_corners() -> None:
    assert Board(kind="chessboard", squares=(9, 7)).is_half_turn_symmetric
    assert not CHESSBOARD.is_half_turn_symmetric
    assert not Board(squares=(9, 7)).is_half_turn_symmetric


def test_half_turns_of_a_chessboard_do_not_change_the_camera() -> None:
    camera = truth("rectilinear")
    views = captured(camera, CHESSBOARD, count=8)
    turned = [
        View((10, 7, 0) - view.object_points, view.image_points) if i % 2 else view
        for i, view in enumerate(views)
    ]
    one, other = fit(views, camera.img_size).camera, fit(turned, camera.img_size).camera
    np.testing.assert_allclose(one.intrinsics, other.intrinsics, rtol=1e-5, atol=1e-5)


def test_inverted_board_is_the_negative() -> None:
    black, white = draw_board(Board(), 40), draw_board(Board(inverted=True), 40)
    np.testing.assert_array_equal(255 - black, white)
    first = draw_board(CHESSBOARD, 40)[:40, :40]
    assert (first == 0).all()


def test_views_of_a_board_on_a_screen_are_flat() -> None:
    places = np.zeros((6, 2))
    assert Board.from_record({"surface": "screen"}).view(range(6), places).flat
    assert not Board().view(range(6), places).flat
    with pytest.raises(ValueError, match="surface"):
        Board(surface="tablet")
