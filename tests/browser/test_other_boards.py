"""Chessboards, AprilGrids and inverted boards, in drawn photographs and before the simulated camera."""

from __future__ import annotations

import base64
import json
from typing import Any

import cv2
import numpy as np
import pytest
from playwright.sync_api import FilePayload, Page, Request, expect

from calibsolver import Board, fit
from tests.helpers.browser.photographs import CAMERA, board_photographs, jpeg, sent_views
from tests.helpers.browser.truth import SMALL

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
COUNT = 8

FIND = """async (series) => {
  const { Detector } = await import("/lib/detector.js");
  const { recognise } = await import("/lib/board-recognition.js");
  const { DEFAULT_BOARD } = await import("/lib/board.js");
  const bytes = (data) => Uint8Array.from(atob(data), (character) => character.charCodeAt(0));
  const bitmap = (data) => createImageBitmap(new Blob([bytes(data)]));
  const detector = await Detector.open(DEFAULT_BOARD);
  const outcomes = {};
  for (const [name, pictures] of Object.entries(series)) {
    await detector.change(DEFAULT_BOARD);
    const first = await bitmap(pictures[0]);
    const found = recognise([await detector.sight(first, { families: [], inverted: true, timeout: 120000 })]);
    if (!found) continue;
    await detector.change(found.board);
    const views = [];
    for (const data of pictures) {
      views.push(await detector.detect(await bitmap(data), { full: true, timeout: 120000 }));
    }
    outcomes[name] = { board: found.board, views: views.map(({ ids, points }) => ({ ids, points })) };
  }
  detector.close();
  return outcomes;
}"""


@pytest.mark.parametrize(
    "names",
    [
        pytest.param(("aprilgrid", "inverted"), id="markers"),
        pytest.param(("chessboard",), id="chessboard", marks=pytest.mark.thorough),
    ],
)
def test_boards_are_recognised_and_give_what_opencv_gives(page: Page, names: tuple[str, ...]) -> None:
    """Each board is recognised; fx is OpenCV's on the same corners: a chessboard's within 0.05 px."""
    series = {name: list(board_photographs(TOLD[name][0], COUNT)) for name in names}
    data = {
        name: [base64.b64encode(cv2.imencode(".png", picture)[1].tobytes()).decode() for picture in pictures]
        for name, pictures in series.items()
    }
    page.goto("/board/")
    outcomes = page.evaluate(FIND, data)
    for name, pictures in series.items():
        check(name, outcomes.get(name), pictures)


def check(name: str, found: dict[str, Any] | None, pictures: list[Any]) -> None:
    board, told = TOLD[name]
    assert found is not None, name
    assert {key: found["board"].get(key) for key in told} == told
    views = [board.view(v["ids"], v["points"]) for v in found["views"] if len(v["ids"]) >= 6]
    assert len(views) == COUNT
    objects = [view.object_points.astype(np.float32) for view in views]
    points = [view.image_points.astype(np.float32)[:, None] for view in views]
    extended = cv2.calibrateCameraExtended(objects, points, CAMERA.size, None, None)
    matrix, deviations = extended[1], extended[5]
    ours = fit(views, CAMERA.size).camera.matrix[0, 0]
    print(f"{name}: fx {ours:.3f}, OpenCV with the same corners {matrix[0, 0]:.3f}, truth {CAMERA.fx}")
    if name == "chessboard":
        assert abs(ours - matrix[0, 0]) < 0.05
        assert abs(ours - with_opencv_corners(pictures)) < deviations[0][0]
    assert abs(ours - matrix[0, 0]) < deviations[0][0]
    assert abs(ours - CAMERA.fx) < 0.005 * CAMERA.fx


def with_opencv_corners(pictures: list[Any]) -> float:
    """Focal length by OpenCV with the corners that OpenCV finds in pictures of the chessboard, px."""
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


@pytest.mark.parametrize("name", ["chessboard", pytest.param("aprilgrid", marks=pytest.mark.thorough)])
def test_live_capture_follows_boards_of_other_kinds(page: Page, name: str) -> None:
    """A guided capture of the simulated camera ends by itself, within 0.2 % of its focal length."""
    page.goto(f"/calibrate/?{SMALL.query(seed=3)}&{LIVE[name]}")
    page.locator("#done:not([hidden]) #json").wait_for(state="attached")
    found = json.loads(page.locator("#json").text_content() or "")["camera_matrix"][0][0]
    print(f"{name}: fx {found:.2f}, truth {SMALL.fx}")
    assert abs(found / SMALL.fx - 1) < 0.002


def test_folder_of_chessboard_pictures_gives_what_opencv_gives(page: Page) -> None:
    """Nine by six corners, no board named: fx is `cv2.calibrateCamera`'s of the same corners, to 0.05 px."""
    sent: list[Request] = []
    files = [jpeg(grey) for grey in board_photographs(CHESSBOARD, COUNT)]
    page.goto("/photos/")
    page.on("request", lambda request: sent.append(request))
    page.locator("#files").set_input_files(
        [
            FilePayload(name=f"chess-{n}.jpg", mimeType="image/jpeg", buffer=content)
            for n, content in enumerate(files)
        ]
    )
    expect(page.locator("#question-text")).to_contain_text("10 × 7 chessboard")
    page.locator("#use-board").click()
    page.locator("#status", has_text=f"The board was found in {COUNT} of {COUNT} photos").wait_for()
    page.locator("#model").select_option("rectilinear")
    page.locator("#start").click()
    page.locator("#verdict").wait_for()
    found = json.loads(page.locator("#json").text_content() or "")["camera_matrix"][0][0]
    views = sent_views(sent)
    assert len(views) == COUNT
    objects = [CHESSBOARD.points[view["ids"]].astype(np.float32) for view in views]
    points = [np.array(view["points"], dtype=np.float32)[:, None] for view in views]
    extended = cv2.calibrateCameraExtended(objects, points, CAMERA.size, None, None)
    matrix, deviations = extended[1], extended[5]
    print(f"fx {found:.3f}, OpenCV with the same corners {matrix[0, 0]:.3f}, truth {CAMERA.fx}")
    assert abs(found - matrix[0, 0]) < 0.05
    pictures = [cv2.imdecode(np.frombuffer(each, np.uint8), cv2.IMREAD_GRAYSCALE) for each in files]
    assert abs(found - with_opencv_corners(pictures)) < deviations[0][0]
    assert abs(found - CAMERA.fx) < 0.005 * CAMERA.fx
