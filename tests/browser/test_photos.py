"""Calibration from photographs and from a video: drawn ones, and real ones where CALIBDB_DATA has them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import pytest
from playwright.sync_api import BrowserContext, Page, Request, Route, expect

from tests.helpers.browser import photographs
from tests.helpers.browser.pictures import picture
from tests.helpers.browser.waiting import until
from tests.helpers.data import data_dir, external_data

BOARD = "squares=8x8&marker_ratio=0.75&dictionary=DICT_4X4_1000"
PAGE = f"/photos/?{BOARD}"
NAME = "LifeCam HD-3000"
SIZES = ("640x480", "1280x720")


@dataclass(frozen=True)
class Series:
    """Photographs by one camera, one of another size, and what is known of the camera.

    `ratio` is fx over the width, within `tolerance`; `named` is the camera's name as the files say it;
    `fewest` is how many photographs the page must use at least.
    """

    photographs: list[Path]
    larger: Path
    ratio: float
    tolerance: float
    named: str
    fewest: int


@pytest.fixture(scope="module", params=["drawn", pytest.param("real", marks=external_data)])
def series(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Series:
    if request.param == "drawn":
        folder = tmp_path_factory.mktemp("photographs")
        ratio = photographs.CAMERA.fx / photographs.CAMERA.size[0]
        named = f"{photographs.MAKE} {photographs.MODEL}"
        drawn = photographs.draw(folder)
        return Series(drawn, photographs.draw_other(folder), ratio, 0.003, named, fewest=11)
    small, large = (sorted((data_dir() / "photos" / f"charuco_{size}").glob("*.jpg")) for size in SIZES)
    # What plain OpenCV makes of all of them: fx/w = 1.06.
    return Series(small[5:], large[0], 1.06, 0.02, "", fewest=11)


def calibrate(page: Page) -> None:
    page.locator("#camera").fill(NAME)
    page.locator("#start").click()
    page.locator("#verdict").wait_for()


def test_photographs_become_a_calibration_and_stay_here(page: Page, series: Series) -> None:
    sent: list[Request] = []
    page.goto(PAGE)
    page.on("request", lambda request: sent.append(request))
    page.locator("#files").set_input_files([*series.photographs, series.larger])
    page.locator("#status", has_text="The board was found in 13 of 13").wait_for()
    expect(page.locator("#pictures .what", has_text="another camera, lens or size")).to_have_count(1)
    expect(page.locator("#series option").first).to_contain_text("640 × 480 · 12 views")
    expect(page.locator("#camera")).to_have_value(series.named)
    calibrate(page)
    assert page.locator("#pictures .taken").count() >= series.fewest
    calibration = json.loads(page.locator("#json").text_content() or "")
    fx = calibration["camera_matrix"][0][0]
    print(f"fx/w {fx / 640:.4f}, {series.ratio:.4f} expected")
    assert fx / 640 == pytest.approx(series.ratio, abs=series.tolerance)
    assert (calibration["camera"], calibration["platform"]) == (NAME, "photographs")
    page.locator(".compare canvas").nth(1).wait_for()
    picture(page, "photos-done", full=True)
    for request in sent:
        body = request.post_data
        if request.url.startswith("blob:") or body is None:
            continue
        assert set(json.loads(body)) <= {
            "camera", "platform", "img_size", "zoom", "distortion_model", "board", "capture",
            "index", "ids", "points",
        }  # fmt: skip


def test_too_little_is_not_stored_but_what_would_help_is_drawn(page: Page, series: Series) -> None:
    page.goto(PAGE)
    page.locator("#files").set_input_files(series.photographs[:1])
    page.locator("#status", has_text="The board was found in 1 of 1").wait_for()
    page.locator("#camera").fill(NAME)
    page.locator("#start").click()
    page.locator("#wanted figure").wait_for()
    expect(page.locator("#status")).to_contain_text("not enough yet")
    picture(page, "photos-more", ["hand"], full=True)

    held: list[Route] = []
    page.route("**/v1/auth", lambda route: held.append(route))
    page.locator("#start").click()
    until(page, lambda: held)
    page.locator("#clear").click()
    expect(page.locator("#pictures li")).to_have_count(0)
    expect(page.locator("#form")).to_be_hidden()
    held[0].continue_()
    page.locator("#start:enabled").wait_for(state="attached")
    expect(page.locator("#status"), "what is computed of them comes too late").to_have_text("")
    expect(page.locator("#wanted figure")).to_have_count(0)


def test_another_board_is_not_taken_for_this_one(context: BrowserContext, series: Series) -> None:
    page = context.new_page()
    page.goto("/photos/")
    page.locator("#files").set_input_files(series.photographs[:2])
    page.locator("#status", has_text="Do they show the board named above?").wait_for()
    expect(page.locator("#pictures .what", has_text="no board")).to_have_count(2)


@pytest.mark.thorough
def test_a_video_becomes_a_calibration(page: Page, series: Series, tmp_path: Path) -> None:
    film = tmp_path / "film.webm"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"VP80"), 10, (640, 480))
    for photograph in series.photographs:
        frame = cv2.imread(str(photograph), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
        assert frame is not None
        writer.write(frame)
    writer.release()
    page.goto(PAGE)
    page.locator("#files").set_input_files(film)
    page.locator("#status", has_text="The board was found in").wait_for()
    calibrate(page)
    calibration = json.loads(page.locator("#json").text_content() or "")
    assert calibration["camera_matrix"][0][0] / 640 == pytest.approx(series.ratio, abs=0.03)
    assert calibration["platform"] == "video"
