"""Rotations, boards and views."""

import cv2
import numpy as np
import pytest

from calibsolver import Board, Camera, View, fit, models, rotation
from calibsolver.board import DICTIONARIES
from calibsolver.guidance.overlay import draw_board
from tests.helpers.solver.export_sources import captured, truth


def test_rotations_equal_opencv() -> None:
    rng = np.random.default_rng(0)
    rvec = rng.normal(size=(50, 3))
    for v, r in zip(rvec, rotation.matrix(rvec), strict=True):
        np.testing.assert_allclose(r, cv2.Rodrigues(v)[0], atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-5, 1e-3, 1.0, 3.0, np.pi - 1e-9, np.pi])
def test_rotation_vectors_survive(angle: float) -> None:
    axis = np.array([[1.0, 2.0, -2.0]]) / 3
    r = rotation.matrix(angle * axis)
    again = rotation.vector(r)
    np.testing.assert_allclose(rotation.matrix(again), r, atol=1e-12)
    assert np.linalg.norm(again) == pytest.approx(angle, abs=1e-9)


def test_nearest_is_a_rotation_even_of_a_reflection() -> None:
    for m in (np.eye(3) + 0.1, np.diag([1.0, 1.0, -1.0])):
        r = rotation.nearest(m)
        np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(r) == pytest.approx(1)


def test_rotation_to_ray_is_the_shortest_one() -> None:
    rays = np.random.default_rng(0).normal(size=(4, 50, 3))
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    rays[0, 0] = 0, 0, 1
    r = rotation.rotation_to_ray(rays)
    np.testing.assert_allclose(r[..., 2], rays, atol=1e-12)
    np.testing.assert_allclose(r @ np.swapaxes(r, -1, -2), np.broadcast_to(np.eye(3), r.shape), atol=1e-12)
    angle = np.linalg.norm(rotation.vector(r), axis=-1)
    np.testing.assert_allclose(angle, np.arccos(np.clip(rays[..., 2], -1, 1)), atol=1e-7)


@pytest.mark.parametrize("squares", [(9, 6), (8, 8), (5, 7)])
def test_corners_are_opencvs(squares: tuple[int, int]) -> None:
    board = Board(squares=squares)
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    theirs = cv2.aruco.CharucoBoard(squares, 1.0, 0.65, dictionary).getChessboardCorners()
    np.testing.assert_allclose(board.points, np.asarray(theirs), atol=1e-6)


def test_board_and_views_are_made_of_records() -> None:
    record = {"squares": [5, 7], "marker_ratio": 0.7, "dictionary": "DICT_5X5_100", "legacy": True}
    board = Board.from_record(record)
    assert board == Board(squares=(5, 7), marker_ratio=0.7, dictionary="DICT_5X5_100", legacy=True)
    assert hash(board) == hash(Board.from_record({**record, "squares": (5, 7)}))
    assert Board.from_record({}) == Board()
    records = [{"index": 3, "ids": [0, 5], "points": [[1.0, 2.0], [3, 4]]}, {"ids": [], "points": []}]
    first, second = board.views(records)
    np.testing.assert_array_equal(first.object_points, [[1, 1, 0], [2, 2, 0]])
    np.testing.assert_array_equal(first.image_points, [[1, 2], [3, 4]])
    assert len(second) == 0


@pytest.mark.parametrize(
    "values",
    [
        {"squares": (9, 1)},
        {"squares": (2, 6)},
        {"squares": (9.5, 6)},
        {"squares": (9, 100)},
        {"squares": (20, 20)},  # 200 markers, 50 in the dictionary
        {"marker_ratio": 1.0},
        {"marker_ratio": 0.0},
        {"marker_ratio": float("nan")},
        {"dictionary": "DICT_9X9_50"},
        {"kind": "dots"},
        {"kind": "chessboard", "squares": (2, 7)},
        {"kind": "aprilgrid"},  # its dictionary is no AprilTag family
        {"kind": "aprilgrid", "dictionary": "DICT_APRILTAG_16h5", "squares": (6, 6)},
        {"kind": "aprilgrid", "dictionary": "DICT_APRILTAG_36h11", "squares": (1, 1)},
        {"kind": "aprilgrid", "dictionary": "DICT_APRILTAG_36h11", "tag_spacing": 0.0},
    ],
)
def test_impossible_boards_are_refused(values: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"board|marker|dictionary|whole|AprilGrid"):
        Board(**values)  # type: ignore[arg-type]


def test_dictionaries_are_opencvs() -> None:
    for name, count in DICTIONARIES.items():
        known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
        assert (len(known.bytesList), known.markerSize) == (
            count,
            Board(squares=(4, 3), dictionary=name).marker_size,
        )


def test_impossible_views_are_refused() -> None:
    board = Board()
    for ids in ([0, 0], [0, 40], [-1, 3], [0, 1.5]):
        with pytest.raises(ValueError, match="id"):
            board.view(ids, [[10.0, 20.0], [30.0, 40.0]])
    with pytest.raises(ValueError, match="image_points"):
        board.view([0, 1, 2], [[10.0, 20.0]])


def test_views_are_immutable() -> None:
    points = np.zeros((1, 3))
    view = View(points, np.zeros((1, 2)))
    points[0, 0] = 5
    assert view.object_points[0, 0] == 0
    with pytest.raises(ValueError, match="read-only"):
        view.object_points[0, 0] = 1


@pytest.mark.parametrize("model", models.NAMES)
def test_a_camera_takes_one_point_or_many_in_any_kind_of_array(model: str) -> None:
    d = [0.0] * len(models.get(model).coefficients)
    camera = Camera(model, [[900, 0, 640], [0, 910, 360], [0, 0, 1]], d, [1280, 720])
    points = np.array([[0.1, 0.2, 1.0], [-0.3, 0.1, 2.0]])
    pixels = camera.project(points)
    assert pixels.shape == (2, 2)
    for same in (points.tolist(), [points[0], points[1]], points[:, None]):
        np.testing.assert_array_equal(camera.project(same).reshape(2, 2), pixels)
    np.testing.assert_allclose(camera.project(points.astype(np.float32)), pixels, atol=1e-4)
    np.testing.assert_array_equal(camera.project(points[0]), pixels[0])
    rays = camera.unproject(pixels)
    np.testing.assert_allclose(rays, points / np.linalg.norm(points, axis=1, keepdims=True), atol=1e-12)
    np.testing.assert_array_equal(camera.unproject(pixels[1]), rays[1])
    for nothing in ([], np.zeros((0, 3))):
        assert camera.project(nothing).shape == (0, 2)
    for wrong in (points.T, points[:, :2], [1.0]):
        with pytest.raises(ValueError, match="wanted"):
            camera.project(wrong)
    with pytest.raises(ValueError, match="wanted"):
        camera.unproject(points)


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
