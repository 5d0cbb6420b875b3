"""Photographs of a real board by a real camera, through the page's own detector and the API."""

from typing import Any

import cv2
import httpx
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page

from tests.helpers.browser.captures import client
from tests.helpers.data import data_dir, external_data

pytestmark = [external_data, pytest.mark.thorough]
BOARD = {"squares": [8, 8], "marker_ratio": 0.75, "dictionary": "DICT_4X4_1000", "legacy": False}
SIZE = (640, 480)
MIN_POINTS = 6
POINTS = np.array([(x, y, 0) for y in range(1, 8) for x in range(1, 8)], dtype=np.float32)

DETECT = """async ([count, board]) => {
  const { Detector } = await import("/lib/detector.js");
  const detector = await Detector.open(board);
  const found = [];
  for (let index = 0; index < count; index++) {
    const picture = await (await fetch(`/photographs/${index}`)).blob();
    found.push(await detector.detect(await createImageBitmap(picture), { full: true, timeout: 120_000 }));
  }
  detector.close();
  return found;
}"""


def detect(context: BrowserContext, page: Page) -> list[dict[str, Any]]:
    photographs = sorted((data_dir() / "photos" / "charuco_640x480").glob("*.jpg"))
    assert len(photographs) == 17
    context.route(
        "**/photographs/*",
        lambda route: route.fulfill(path=photographs[int(route.request.url.split("/")[-1])]),
    )
    page.goto("/board/")
    found: list[dict[str, Any]] = page.evaluate(DETECT, [len(photographs), BOARD])
    return found


def calibrated_by_opencv(views: list[dict[str, Any]]) -> tuple[float, np.ndarray]:
    rms, matrix, *_ = cv2.calibrateCamera(
        [POINTS[view["ids"]] for view in views],
        [np.array(view["points"], dtype=np.float32)[:, None] for view in views],
        SIZE,
        None,
        None,
    )
    return rms, matrix


def submit(api: httpx.Client, views: list[dict[str, Any]]) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Post views as the page does; the last state, and the views accepted."""
    request = {
        "camera": "Microsoft LifeCam HD-3000 (045e:0779)",
        "platform": "X11; Linux x86_64",
        "img_size": SIZE,
        "board": BOARD,
        "capture": "recorded",
    }
    accepted: list[dict[str, Any]] = []
    with client(api) as session:
        assert session.open(**request).status == 201
        for view in views:
            if session.view(len(accepted), view["ids"], view["points"]).json["accepted"]:
                accepted.append(view)
        return session.call("POST", "/v1/session/finish").json, accepted


def assert_equal_to_opencv(calibration: dict[str, Any], views: list[dict[str, Any]], what: str) -> None:
    rms, matrix = calibrated_by_opencv(views)
    ours = np.array(calibration["camera_matrix"])
    places = ([0, 1, 0, 1], [0, 1, 2, 2])
    ratio = ours[places] / matrix[places] - 1
    error = calibration["avg_reprojection_error"] / rms - 1
    print(f"{what}: {len(views)} views, fx fy cx cy {100 * ratio} %, rms {rms:.4f} px {100 * error:+.2f} %")
    assert np.abs(ratio).max() < 0.01
    assert abs(error) < 0.02


def test_photographs_give_what_opencv_gives(context: BrowserContext, page: Page, api: httpx.Client) -> None:
    found = detect(context, page)
    usable = [view for view in found if len(view["ids"]) >= MIN_POINTS]
    assert len(usable) >= 16, "boards that cv2 finds in all 17 photographs"
    assert {tuple(view["size"]) for view in found} == {SIZE}

    state, accepted = submit(api, usable)
    assert state["status"] == "converged"
    assert len(accepted) >= len(usable) - 1
    stored = api.get(f"/calibrations/{state['calibration_id']}").json()
    assert_equal_to_opencv(stored, accepted, "stored")
