"""Overlay: the picture agrees with the target's coordinates."""

from functools import cache
from typing import Literal

import cv2
import numpy as np
import pytest

from calibsolver import Board, Camera, fit, guidance, rotation
from calibsolver.guidance import ProjectionUncertainty, TargetPose, overlay
from tests.helpers.marks import thorough
from tests.helpers.solver import populations, synthetic

BOARD, SIZE = Board(), synthetic.IMG_SIZE
Format = Literal["jpeg", "png"]


def drawn(board: Board, camera: Camera, target: TargetPose, image_format: Format = "png") -> np.ndarray:
    data = overlay.render(board, camera, target, image_format)
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert picture is not None
    return picture


def first(board: Board, size: tuple[int, int] = SIZE, kind: str = "rectilinear") -> tuple[Camera, TargetPose]:
    """Camera before the first view, and its target."""
    camera = guidance.IntrinsicsPosterior.of(kind, size, None).camera
    return camera, ProjectionUncertainty(board, size, kind).next_pose([], None)


@cache
def targets(kind: str) -> list[tuple[Camera, TargetPose]]:
    cameras = synthetic.rectilinear_cameras() if kind == "rectilinear" else synthetic.fisheye_cameras()
    views = populations.views(cameras[6], np.random.default_rng(0), count=4)
    calibration = fit(views, SIZE, kind)
    target = ProjectionUncertainty(BOARD, SIZE, kind).next_pose(views, calibration)
    return [(calibration.camera, target), first(BOARD, kind=kind)]


@pytest.mark.parametrize("kind", ["rectilinear", "fisheye"])
def test_poses_are_near_and_visible(kind: str) -> None:
    for camera, target in targets(kind):
        p = BOARD.outline @ target.r.T + target.tvec
        if kind == "rectilinear":
            assert (p[:, 2] > 0).all()
        # Seen from the front: every line of sight meets the printed side.
        assert (p @ target.r[:, 2] > 0).all()
        assert len(target.ids) >= 0.6 * BOARD.corner_count
        assert np.linalg.norm(p.mean(axis=0)) < 4 * BOARD.size[0]
        q = camera.project(BOARD.points[list(target.ids)] @ target.r.T + target.tvec)
        np.testing.assert_allclose(q, target.corners, atol=1e-9)
        assert target.gain > 0


@pytest.mark.parametrize("kind", ["rectilinear", "fisheye"])
def test_picture_shows_corners_at_their_coordinates(kind: str) -> None:
    for camera, target in targets(kind):
        green = np.ascontiguousarray(drawn(BOARD, camera, target)[:, :, 1])
        q = target.corners
        inside = q[((q > 20) & (q < np.array(SIZE) - 20)).all(axis=1)]
        criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 50, 0.001)
        start = inside.astype(np.float32).reshape(-1, 1, 2)
        refined = cv2.cornerSubPix(green, start, (4, 4), (-1, -1), criteria)
        off = np.linalg.norm(refined[:, 0] - inside, axis=1)
        assert len(off) > 10
        assert np.median(off) < 0.1
        assert np.percentile(off, 90) < 0.3


@pytest.mark.parametrize("kind", ["rectilinear", "fisheye"])
def test_board_is_coloured_and_background_black(kind: str) -> None:
    background = []
    for camera, target in targets(kind):
        assert len(overlay.render(BOARD, camera, target)) <= 60 * 1024
        picture = drawn(BOARD, camera, target, "jpeg")
        assert picture.shape == (720, 1280, 3)
        polygon = np.zeros((720, 1280), np.uint8)
        cv2.fillPoly(polygon, [np.round(target.outline).astype(np.int32)], 255)
        inside = cv2.erode(polygon, np.ones((9, 9))) > 0
        outside = cv2.dilate(polygon, np.ones((9, 9))) == 0
        # The edge of the domain cuts boards that reach beyond it; on these cameras it lies outside the image.
        assert picture.max(axis=2)[inside].min() > 60
        luma = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
        assert luma[inside].min() > 20
        background.append(picture.max(axis=2)[outside])  # a close-up may fill the picture
    # What JPEG leaves of the edges: a threshold far below the board's darkest separates them.
    assert np.percentile(np.concatenate(background), 99.9) < 30
    assert outside.sum() > 100_000  # of the last one, the easy one


def test_png_is_transparent_outside_the_board() -> None:
    camera, target = targets("rectilinear")[-1]
    picture = drawn(BOARD, camera, target)
    assert picture.shape == (720, 1280, 4)
    alpha = picture[:, :, 3]
    assert set(np.unique(alpha)) >= {0, 255}
    jpeg = drawn(BOARD, camera, target, "jpeg").max(axis=2)
    assert np.mean((alpha > 127) == (jpeg > 127)) > 0.99


def test_opencv_detects_the_drawn_markers() -> None:
    """OpenCV's own detector reads the board back from the green channel, each id at its corner."""
    for board in (BOARD, Board(squares=(8, 8), marker_ratio=0.75, dictionary="DICT_4X4_1000")):
        camera, target = first(board)
        picture = drawn(board, camera, target)
        # On black nothing separates the outer markers from the background: make it white.
        green = np.where(picture[:, :, 3] == 0, 255, picture[:, :, 1]).astype(np.uint8)
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
        charuco = cv2.aruco.CharucoBoard(board.squares, 1.0, board.marker_ratio, dictionary)
        corners, ids, _, _ = cv2.aruco.CharucoDetector(charuco).detectBoard(green)
        assert ids is not None
        assert len(ids) > 0.8 * board.corner_count
        where = dict(zip(target.ids, target.corners, strict=True))
        expected = np.array([where[i] for i in ids.ravel().tolist()])
        assert np.median(np.linalg.norm(corners.reshape(-1, 2) - expected, axis=1)) < 0.5


def test_board_is_cut_at_the_end_of_the_domain() -> None:
    """A board across the model's edge, 1 / sqrt(1.2) focal lengths from the axis, is cut."""
    matrix = np.array([[500, 0, 639.5], [0, 500, 359.5], [0, 0, 1.0]])
    camera = Camera("rectilinear", matrix, np.array([-0.4, 0, 0, 0, 0]), SIZE)
    r = rotation.matrix(np.array([0.1, 0.0, 0.0]))
    target = TargetPose.seen(BOARD, camera, r, np.array([-1.0, -3.0, 6.0]), "", 0.0)
    y, x = np.nonzero(drawn(BOARD, camera, target)[:, :, 3])
    edge = 500 * (1 / np.sqrt(1.2)) * (1 - 0.4 / 1.2)
    assert len(x) > 10_000
    assert np.hypot(x - 639.5, y - 359.5).max() <= edge + 1
    assert np.isfinite(target.outline).all()
    assert 0 < len(target.ids) < BOARD.corner_count


def test_board_outside_the_image_is_an_empty_picture() -> None:
    camera, _ = first(BOARD)
    far = TargetPose.seen(BOARD, camera, np.eye(3), np.array([60.0, 0.0, 20.0]), "", 0.0)
    assert far.ids == ()
    assert drawn(BOARD, camera, far, "jpeg").max() < 10


@pytest.mark.parametrize("image_format", ["jpeg", *thorough("png")])
def test_large_picture_is_drawn_smaller(image_format: Format, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the same shape, the board in the same place."""
    w, h = overlay.drawn_size((8192, 6144))
    assert 11.9e6 < w * h <= 12e6
    assert overlay.drawn_size((4000, 3000)) == (4000, 3000)
    monkeypatch.setattr(overlay, "MAX_PICTURE_PX", 480_000)
    size = (1638, 1229)
    matrix = np.array([[1600.0, 0, 800], [0, 1600, 600], [0, 0, 1]])
    camera = Camera("rectilinear", matrix, [0.1, 0, 0, 0, 0], size)
    target = TargetPose.seen(BOARD, camera, np.eye(3), np.array([-4.0, -3.0, 16.0]), "", 0.0)
    picture = drawn(BOARD, camera, target, image_format)
    w, h = overlay.drawn_size(size)
    assert picture.shape[:2] == (h, w)
    assert w * h <= 480_000
    assert w / h == pytest.approx(size[0] / size[1], rel=1e-3)
    rows, columns = np.nonzero(picture.max(axis=2) > 100)
    outline = (target.outline + 0.5) * (w / size[0], h / size[1]) - 0.5
    low, high = np.maximum(outline.min(axis=0), 0), np.minimum(outline.max(axis=0), (w - 1, h - 1))
    assert np.abs(low - (columns.min(), rows.min())).max() < 8
    assert np.abs(high - (columns.max(), rows.max())).max() < 8


def test_unknown_format_is_refused() -> None:
    with pytest.raises(ValueError, match="format"):
        overlay.render(BOARD, *first(BOARD), "gif")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "board",
    [
        Board(squares=(12, 12), dictionary="DICT_7X7_100", marker_ratio=0.1),
        Board(squares=(3, 3), dictionary="DICT_ARUCO_ORIGINAL", marker_ratio=0.95),
        Board(squares=(40, 40), dictionary="DICT_6X6_1000"),
    ],
)
def test_extreme_boards_are_drawn(board: Board) -> None:
    assert drawn(board, *first(board, (640, 480)), "jpeg").shape == (480, 640, 3)
