"""Calibration from photos and videos, drawn and real ones."""

import json
import re
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, Request, Route, expect

from calibsolver import Board
from tests.helpers.browser import photographs
from tests.helpers.browser.photographs import opencv_fit, sent_views
from tests.helpers.browser.pictures import picture
from tests.helpers.browser.waiting import shown_calibration, until
from tests.helpers.data import EXTERNAL, data_dir, external_data
from tests.helpers.marks import thorough

BOARD = "squares=8x8&marker_ratio=0.75&dictionary=DICT_4X4_1000"
PAGE = f"/photos/?{BOARD}"
NAME = "LifeCam HD-3000"
SIZES = ("640x480", "1280x720")
PARAMETERS = ([0, 1, 0, 1], [0, 1, 2, 2])  # fx, fy, cx, cy of a matrix


@dataclass(frozen=True)
class Series:
    """Photos by one camera and one of another size.

    `ratio`: fx over the width, within `tolerance`; `named`: the camera in the files; `fewest`: photos to use.
    """

    photographs: list[Path]
    larger: Path
    ratio: float
    tolerance: float
    named: str
    fewest: int
    page: str


# Drawn ones stand in for the real ones.
DRAWN = ["drawn"] if EXTERNAL is None else thorough("drawn")


@pytest.fixture(scope="module", params=[*DRAWN, pytest.param("real", marks=external_data)])
def series(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Series:
    if request.param == "drawn":
        folder = tmp_path_factory.mktemp("photographs")
        ratio = photographs.CAMERA.fx / photographs.CAMERA.size[0]
        named = f"{photographs.MAKE} {photographs.MODEL}"
        drawn = photographs.draw(folder)
        return Series(drawn, photographs.draw_other(folder), ratio, 0.003, named, 11, PAGE)
    small, large = (sorted((data_dir() / "photos" / f"charuco_{size}").glob("*.jpg")) for size in SIZES)
    # What plain OpenCV makes of all of them: fx/w = 1.06.
    return Series(small, large[0], 1.06, 0.02, "", 16, "/photos/")


def calibrate(page: Page) -> None:
    page.locator("#camera").fill(NAME)
    page.locator("#start").click()
    page.locator("#verdict").wait_for()


def too_little_is_not_stored_but_what_would_help_is_drawn(page: Page, series: Series) -> None:
    page.locator("#clear").click()
    page.locator("#files").set_input_files(series.photographs[:1])
    page.locator("#status", has_text="The board was found in 1 of 1 photos").wait_for()
    page.locator("#camera").fill(NAME)
    page.locator("#start").click()
    page.locator("#wanted figure").wait_for()
    expect(page.locator("#status")).to_contain_text("A calibration needs four photos that agree")
    picture(page, "photos-more", ["hand"], full=True)

    held: list[Route] = []
    page.route("**/v1/auth", lambda route: held.append(route), times=1)
    page.locator("#start").click()
    until(page, lambda: held)
    page.locator("#clear").click()
    expect(page.locator("#pictures li")).to_have_count(0)
    expect(page.locator("#form")).to_be_hidden()
    held[0].continue_()
    page.locator("#start:enabled").wait_for(state="attached")
    expect(page.locator("#status"), "what is computed of them comes too late").to_have_text("")
    expect(page.locator("#wanted figure")).to_have_count(0)


def test_photographs_become_a_calibration_and_stay_here(page: Page, series: Series) -> None:
    """Every sharp one counts, and the real ones' board is recognised: fx is OpenCV's within one sigma."""
    sent: list[Request] = []
    page.goto(series.page)
    page.on("request", lambda request: sent.append(request))
    page.locator("#files").set_input_files([*series.photographs, series.larger])
    if series.page == "/photos/":
        expect(page.locator("#question-text")).to_contain_text("8 × 8 ChArUco, DICT_4X4_50, markers 0.75")
        picture(page, "photos-question", ["desk"])
        page.locator("#use-board").click()
    all_of_them = len(series.photographs) + 1
    page.locator("#status", has_text=f"of {all_of_them} photos").wait_for()
    expect(page.locator("#pictures .what", has_text="another camera, lens or size")).to_have_count(1)
    expect(page.locator("#series option").first).to_contain_text("640 × 480 · ")
    expect(page.locator("#camera")).to_have_value(series.named or "Microsoft LifeCam HD-3000")
    calibrate(page)
    assert page.locator("#pictures .taken").count() >= series.fewest
    calibration = shown_calibration(page)
    fx = calibration["camera_matrix"][0][0]
    rms, matrix, deviation = opencv_fit(Board(squares=(8, 8)), sent_views(sent), (640, 480))
    ratio = np.array(calibration["camera_matrix"])[PARAMETERS] / matrix[PARAMETERS] - 1
    error = calibration["avg_reprojection_error"] / rms - 1
    print(f"fx {fx:.2f}, OpenCV with the same corners {matrix[0, 0]:.2f} +- {deviation:.2f}")
    print(f"fx fy cx cy {100 * ratio} %, rms {rms:.4f} px {100 * error:+.2f} %")
    assert abs(fx - matrix[0, 0]) < deviation
    assert np.abs(ratio).max() < 0.01
    assert abs(error) < 0.02
    assert fx / 640 == pytest.approx(series.ratio, abs=series.tolerance)
    assert (calibration["camera"], calibration["platform"]) == (NAME, "photographs")
    expect(page.locator(".views .source").first).to_contain_text(".jpg")
    page.locator(".compare canvas").nth(1).wait_for()
    assert "/result/?id=" in page.url
    expect(page).to_have_title(re.compile(f"{NAME} .*: (Good|Fair) · calibDB"))
    expect(page.locator("#form")).to_be_hidden()
    expect(page.locator(".views image").first).to_have_attribute("href", re.compile("^data:image/jpeg"))
    picture(page, "photos-done", full=True)
    page.go_back()
    assert page.url.endswith(series.page)
    expect(page.locator("#pictures .taken").first).to_be_visible()
    expect(page.locator("#verdict")).to_be_hidden()
    expect(page).to_have_title("Calibrate from photos · calibDB")
    too_little_is_not_stored_but_what_would_help_is_drawn(page, series)
    page.go_forward()
    expect(page.locator("#verdict")).to_be_visible()
    for request in sent:
        body = request.post_data
        if request.url.startswith("blob:") or body is None:
            continue
        if request.url.endswith("/v1/lookup"):  # for the estimate: what the files say of their camera
            asked = {"camera", "platform", "img_size", "zoom", "reported", "redirect", "miss"}
            assert set(json.loads(body)) <= asked
            continue
        assert set(json.loads(body)) <= {
            "camera", "platform", "img_size", "zoom", "distortion_model", "board", "capture",
            "index", "views",
        }  # fmt: skip


@pytest.mark.thorough
def test_files_stay_while_the_board_changes(context: BrowserContext, series: Series) -> None:
    page = context.new_page()
    page.goto("/photos/?squares=9x6")
    page.locator("#files").set_input_files([*series.photographs[:2], __file__])
    expect(page.locator("#question-text")).to_contain_text("8 × 8 ChArUco")
    page.locator("#other-board").click()
    expect(page.locator("#which-board")).to_have_attribute("open", "")
    page.locator("#preset").select_option("photonvision")
    page.locator("#status", has_text="The board was found in 2 of 2 photos").wait_for()
    expect(page.locator("#status")).to_contain_text("Not a photo or video: test_photos.py")
    expect(page.locator("#board")).to_contain_text("DICT_4X4_1000")


@pytest.mark.thorough
def test_a_mirrored_video_becomes_a_calibration(page: Page, series: Series, tmp_path: Path) -> None:
    film = tmp_path / "film.webm"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"VP80"), 10, (640, 480))
    for photograph in series.photographs:
        frame = cv2.imread(str(photograph), cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION)
        assert frame is not None
        writer.write(cv2.flip(frame, 1))
    writer.release()
    page.goto(PAGE)
    page.locator("#files").set_input_files(film)
    expect(page.locator("#question-text")).to_contain_text("mirrored")
    page.locator("#use-board").click()
    page.locator("#status", has_text="video frames").wait_for()
    calibrate(page)
    calibration = shown_calibration(page)
    assert calibration["camera_matrix"][0][0] / 640 == pytest.approx(series.ratio, abs=0.03)
    assert calibration["platform"] == "video"
