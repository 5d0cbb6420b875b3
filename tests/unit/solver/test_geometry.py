"""Rotations, boards and views."""

import cv2
import numpy as np
import pytest

from calibsolver import Board, Camera, View, models, rotation
from calibsolver.board import DICTIONARIES


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
        {"kind": "aprilgrid", "dictionary": "DICT_APRILTAG_36h11", "tag_spacing": float("nan")},
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
