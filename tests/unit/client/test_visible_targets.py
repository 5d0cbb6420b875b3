"""Targets that are asked for, drawn as a camera would see them: the detector finds the board in each."""

import cv2
import numpy as np
import pytest

from calibdb_client import Board
from calibdb_client.detection import Detector
from calibsolver import Camera, rotation
from calibsolver.capture import Capture
from calibsolver.guidance import TargetPose
from calibsolver.guidance.overlay import draw_board
from tests.conftest import THOROUGH
from tests.helpers.marks import thorough
from tests.helpers.solver import synthetic

TARGETS = 4 if THOROUGH else 2
SQUARE_PX = 48
SAMPLES = 3
PICTURES = 5
BLUR_PX, NOISE = 0.8, 2.0
MIN_CORNERS = 6
"""Corners of a target that the detector must find: with fewer no view is taken."""
BOARDS = {
    "charuco": Board((9, 6)),
    "6x6 markers": Board((8, 8), marker_ratio=0.75, dictionary="DICT_6X6_250"),
    "many squares": Board((14, 9), marker_ratio=0.75, dictionary="DICT_5X5_1000"),
    "aprilgrid": Board((6, 6), kind="aprilgrid"),
    "chessboard": Board((11, 8), kind="chessboard"),
    "few squares": Board((4, 5), marker_ratio=0.75),
    "fewest squares": Board((3, 4)),
    "few tags": Board((2, 2), kind="aprilgrid"),
}
HD = {"most squares": Board((24, 17), marker_ratio=0.7, dictionary="DICT_7X7_1000")}
"""Boards whose markers a picture of 640 px cannot show."""
CASES = [(name, (640, 480)) for name in BOARDS] + [(name, (1280, 720)) for name in {**BOARDS, **HD}]
CORNERS = [
    ("many squares", (640, 480)),
    ("chessboard", (640, 480)),
    ("fewest squares", (640, 480)),
    ("few tags", (1280, 720)),
]
"""The densest board that so small an image shows, the one that counts only as a whole, and the sparsest."""


def drawn(board: Board, camera: Camera, target: TargetPose, seed: int) -> np.ndarray:
    """Draw the board at a target, seen by a camera without distortion, blurred and with noise."""
    margin = (SQUARE_PX,) * 4
    texture = cv2.copyMakeBorder(
        draw_board(board, SQUARE_PX), *margin, cv2.BORDER_CONSTANT, value=(255, 255, 255)
    )
    x, y = board.outline[0, :2] - 1 + 0.5 / SQUARE_PX
    to_board = np.array([[1 / SQUARE_PX, 0, x], [0, 1 / SQUARE_PX, y], [0, 0, 1]])
    plane = np.column_stack([rotation.matrix(target.rvec)[:, :2], target.tvec])
    shift = (SAMPLES - 1) / 2
    finer = np.array([[SAMPLES, 0, shift], [0, SAMPLES, shift], [0, 0, 1]])
    w, h = camera.img_size
    fine = cv2.warpPerspective(
        texture,
        finer @ camera.matrix @ plane @ to_board,
        (SAMPLES * w, SAMPLES * h),
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=(110, 110, 110),
    )
    grey = cv2.resize(fine, (w, h), interpolation=cv2.INTER_AREA).astype(float)
    blurred = cv2.GaussianBlur(30 + 0.75 * grey, (0, 0), BLUR_PX)
    noise = np.random.default_rng(seed).normal(0, NOISE, blurred.shape)
    return np.clip(blurred + noise, 0, 255).astype(np.uint8)


@pytest.mark.parametrize(
    ("name", "size"), [*CORNERS, *thorough(*(case for case in CASES if case not in CORNERS))]
)
def test_detector_finds_the_board_at_every_target(name: str, size: tuple[int, int]) -> None:
    """All of a chessboard, and of others enough corners for a view."""
    board = {**BOARDS, **HD}[name]
    detector = Detector(board)
    capture = Capture(board, size, target_error=0.001)
    camera, views, estimate = capture.camera(None), [], capture.estimate([])
    for number in range(TARGETS):
        target = capture.next_target(views, estimate)
        found = detector.find(drawn(board, camera, target, number))
        seen = set() if found is None else set(found.ids) & set(target.ids)
        counted = len(target.ids)
        needed = counted if board.kind == "chessboard" else MIN_CORNERS
        assert len(seen) >= needed, f"target {number}: {len(seen)} of {counted} corners"
        turn = rotation.matrix(target.rvec)
        points = camera.project(board.points[list(target.ids)] @ turn.T + target.tvec)
        points = points + np.random.default_rng(number).normal(0, 0.15, points.shape)
        views.append(board.view(target.ids, points))
        estimate = capture.estimate(views)


@pytest.mark.parametrize("name", ["charuco", "aprilgrid", *thorough("6x6 markers")])
def test_simulated_detector_reports_the_corners_that_the_detector_finds(name: str) -> None:
    """Of boards that the picture cuts: at most 2 % differ."""
    board, rng = BOARDS[name], np.random.default_rng(0)
    camera = Camera("rectilinear", [[560, 0, 322], [0, 558, 237], [0, 0, 1]], [0, 0, 0, 0, 0], (640, 480))
    detector, different, count = Detector(board), 0, 0
    for number in range(PICTURES):
        turn = rotation.matrix(np.radians([*rng.uniform(-35, 35, 2), rng.uniform(-30, 30)]))
        depth = camera.focal[0] / camera.img_size[0] * max(board.size) / rng.uniform(0.7, 1.3)
        place = depth * np.array([rng.uniform(-0.5, 0.5), rng.uniform(-0.4, 0.4), 1])
        target = TargetPose.seen(board, camera, turn, place - turn @ board.outline.mean(axis=0), "", 0.0)
        found = detector.find(drawn(board, camera, target, number))
        assert found is not None
        view = synthetic.detect(board, camera, target.rvec, target.tvec, rng, noise=0)
        same = (board.points[:, None] == view.object_points).all(axis=2).any(axis=1)
        different += len(set(found.ids) ^ set(np.flatnonzero(same)))
        count += len(view)
    assert different <= 0.02 * count
    assert count < PICTURES * 0.9 * board.corner_count, "boards are cut"
