"""Chessboards, AprilGrids and inverted boards."""

import base64
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import Page

from calibsolver import Board, fit
from tests.helpers.browser.photographs import CAMERA, board_photographs, opencv_fit
from tests.helpers.browser.scripts import PLAIN, page_function
from tests.helpers.browser.truth import SMALL
from tests.helpers.browser.waiting import shown_calibration

CHESSBOARD = Board(kind="chessboard", squares=(10, 7))
APRILGRID = Board(kind="aprilgrid", squares=(4, 3), dictionary="DICT_APRILTAG_36h11", tag_spacing=0.25)
INVERTED = Board(squares=(8, 6), marker_ratio=0.7, inverted=True)
TOLD: dict[str, tuple[Board, dict[str, Any]]] = {
    "chessboard": (CHESSBOARD, {"kind": "chessboard", "squares": [10, 7]}),
    "aprilgrid": (
        APRILGRID,
        {"kind": "aprilgrid", "squares": [4, 3], "dictionary": "DICT_APRILTAG_36h11", "tag_spacing": 0.25},
    ),
    "inverted": (INVERTED, {"squares": [8, 6], "marker_ratio": 0.7, "inverted": True}),
}
COUNT = 6

FIND = page_function("recognise_boards")


@pytest.mark.parametrize(
    "names",
    [
        pytest.param(("aprilgrid", "inverted"), id="markers"),
        pytest.param(("chessboard",), id="chessboard", marks=pytest.mark.thorough),
    ],
)
def test_boards_are_recognised_and_fitted_as_by_opencv(page: Page, names: tuple[str, ...]) -> None:
    """Each board is recognised; fx is OpenCV's on the same corners: a chessboard's within 0.05 px."""
    series = {name: list(board_photographs(TOLD[name][0], COUNT)) for name in names}
    data = {
        name: [base64.b64encode(cv2.imencode(".png", picture)[1].tobytes()).decode() for picture in pictures]
        for name, pictures in series.items()
    }
    page.goto(PLAIN)
    outcomes = page.evaluate(FIND, data)
    for name, pictures in series.items():
        check(name, outcomes.get(name), pictures)


def check(name: str, found: dict[str, Any] | None, pictures: list[Any]) -> None:
    board, told = TOLD[name]
    assert found is not None, name
    assert {key: found["board"].get(key) for key in told} == told
    views = [view for view in found["views"] if len(view["ids"]) >= 6]
    assert len(views) == COUNT
    ours = fit([board.view(view["ids"], view["points"]) for view in views], CAMERA.size).camera.matrix[0, 0]
    compare(name, ours, views, board)
    if name == "chessboard":
        compare_with_opencv_corners(ours, views, pictures)


def compare(name: str, ours: float, views: list[dict[str, Any]], board: Board) -> None:
    _, matrix, deviation = opencv_fit(board, views, CAMERA.size)
    theirs = matrix[0, 0]
    print(f"{name}: fx {ours:.3f}, OpenCV with the same corners {theirs:.3f}, truth {CAMERA.fx}")
    assert abs(ours - theirs) < deviation
    assert abs(ours - CAMERA.fx) < 0.005 * CAMERA.fx


def compare_with_opencv_corners(ours: float, views: list[dict[str, Any]], pictures: list[Any]) -> None:
    _, matrix, deviation = opencv_fit(CHESSBOARD, views, CAMERA.size)
    theirs = matrix[0, 0]
    assert abs(ours - theirs) < 0.05
    assert abs(ours - with_opencv_corners(pictures)) < deviation


def with_opencv_corners(pictures: list[Any]) -> float:
    seen = [cv2.findChessboardCornersSB(p, (9, 6), flags=cv2.CALIB_CB_ACCURACY) for p in pictures]
    theirs = [corners.astype(np.float32) for is_found, corners in seen if is_found]
    whole = [CHESSBOARD.points.astype(np.float32)] * len(theirs)
    _, matrix, *_ = cv2.calibrateCamera(whole, theirs, CAMERA.size, None, None)
    print(f"with the corners of findChessboardCornersSB: {matrix[0, 0]:.3f}")
    return float(matrix[0, 0])


LIVE = {
    "chessboard": "kind=chessboard&squares=10x7",
    "aprilgrid": "kind=aprilgrid&squares=5x4&dictionary=DICT_APRILTAG_36h11&tag_spacing=0.3",
}


@pytest.mark.thorough
@pytest.mark.parametrize("name", LIVE)
def test_live_capture_of_other_boards(page: Page, name: str) -> None:
    page.goto(f"/calibrate/?{SMALL.query(seed=3)}&{LIVE[name]}")
    page.locator("#done:not([hidden]) #json").wait_for(state="attached")
    found = shown_calibration(page)["camera_matrix"][0][0]
    assert abs(found / SMALL.fx - 1) < 0.002
