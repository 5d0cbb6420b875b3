"""Grids of circles: detected in drawn pictures, and the bias of their centres corrected."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from calibdb_client import Board, Calibration
from calibdb_client.detection import Detector
from calibsolver import Camera, View, rotation
from calibsolver.circles import centre_bias, fit_circles
from calibsolver.fitting.fit import fit
from tests.helpers import board_pictures
from tests.helpers.command import calibdb
from tests.helpers.marks import thorough

BOARDS = (
    Board((7, 5), kind="circles", marker_ratio=0.5),
    Board((4, 9), kind="asymmetric_circles", marker_ratio=0.8),
)


@pytest.mark.parametrize("board", BOARDS, ids=str)
def test_circles_are_detected_where_they_were_drawn(board: Board) -> None:
    tilt = (0.2, -0.25, 0.05)
    found = Detector(board).find(board_pictures.picture(board, tilt, 1.4 * max(board.size)))
    assert found is not None
    # OpenCV 4 takes the first column of one of these pictures for another, which is left out.
    missed = board.squares[1] if cv2.__version__.startswith("4.") else 0
    assert len(found.ids) >= board.corner_count - missed
    expected = board_pictures.corners(board, tilt, (0, 0, 1.4 * max(board.size)))
    off = found.points - expected[list(found.ids)]
    assert np.sqrt(np.mean(np.sum(off**2, axis=1))) < 0.35


@pytest.mark.usefixtures("no_suggestion", "working")
@pytest.mark.parametrize("board", [BOARDS[1], *thorough(BOARDS[0])], ids=str)
def test_command_calibrates_pictures_of_circles(board: Board, capfd: pytest.CaptureFixture[str]) -> None:
    Path("photos").mkdir()
    for n, tilt in enumerate(board_pictures.TILTS):
        picture = board_pictures.picture(board, tilt, (1.3 + 0.05 * n) * max(board.size))
        cv2.imwrite(f"photos/{n}.png", picture)
    squares = "x".join(map(str, board.squares))
    options = ["--kind", board.kind, "--squares", squares, "--marker-ratio", str(board.marker_ratio)]
    assert calibdb("calibrate photos --offline -o c.json --model rectilinear", *options) == 0
    found = Calibration.load("c.json")
    assert found.camera_matrix[0, 0] == pytest.approx(board_pictures.MATRIX[0, 0], abs=6)
    assert int(capfd.readouterr().out.splitlines()[0].removeprefix("views")) >= 5
    assert calibdb("submit c.json --label Camera --url http://127.0.0.1:1 --token x") == 2


def test_bias_of_centres_is_corrected() -> None:
    """Centroids of circles as wide as 0.8 of their distance, seen by a wide lens from near, without noise."""
    board = Board((7, 5), kind="circles", marker_ratio=0.8)
    true = Camera("rectilinear", board_pictures.MATRIX, [-0.28, 0.07, 0, 0, 0], (640, 480))
    views, sizes = [], []
    tilts = [(0.6, 0, 0), (-0.6, 0.2, 0), (0.1, 0.7, 0), (0, -0.7, 0.1), (0.4, 0.5, 0), (-0.5, -0.4, 0)]
    for n, tilt in enumerate(np.array(tilts)):
        r = rotation.matrix(tilt)
        t = np.array([0, 0, 7.5 + 0.3 * n]) - r @ [*board.edge.mean(axis=0), 0]
        centres = View(board.points, true.project(board.points @ r.T + t))
        bias = centre_bias(true, centres, np.concatenate([tilt, t]), 0.4)
        views.append(View(board.points, centres.image_points + bias))
        sizes.append(np.linalg.norm(bias, axis=1).max())
    assert 0.3 < max(sizes) < 3, "px"
    plain = fit(views, (640, 480)).camera.matrix
    corrected = fit_circles(views, (640, 480), 0.4)[0]
    assert np.abs(corrected.camera.matrix - true.matrix).max() < 0.05
    assert np.abs(plain - true.matrix).max() > 10 * np.abs(corrected.camera.matrix - true.matrix).max()
    assert corrected.avg_reprojection_error < 0.01
