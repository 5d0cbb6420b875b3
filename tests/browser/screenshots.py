"""Pictures of every page in every state, left in tests/browser/output/ for people to look at.

Not a test by its name, so that `make test` passes over it; the tests hold the same states to what must hold.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

import cv2
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, FilePayload, Page

from tests.helpers.browser.interruptions import SHOWN_TARGET, TURN, UNPLUG, done
from tests.helpers.browser.pictures import SIZES, picture
from tests.helpers.browser.scenes import CAMERA, UNANSWERED, no_network, unreadable
from tests.helpers.browser.specimens import CAMERAS, answer, camera, cameras, result
from tests.helpers.browser.truth import Truth
from tests.helpers.data import data_dir, external_data

from .conftest import OUTPUT

READ = {
    "landing": ("/", "#lens path"),
    "board": ("/board/", "#papers a"),
    "photos": ("/photos/", "#board:not(:empty)"),
    "import": ("/import/", "#model option"),
    "cameras": ("/cameras/", "#found tr"),
    "camera": ("/cameras/?key=c2.specimen", "#camera-name"),
    "result": ("/result/?id=x", "#verdict"),
    "ar": ("/ar/", "h1:not(:empty)"),
    "example": ("/examples/three/", "h1:not(:empty)"),
}
HELD = f"/calibrate/?{Truth().query(seed=3)}&target_error=0.01&error=0"


def specimens(page: Page) -> None:
    answer(page, "**/v1/cameras?*", cameras)
    answer(page, "**/v1/cameras/*", camera)
    answer(page, "**/v1/calibrations/x", result)


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", READ)
def test_pages_one_reads(page: Page, name: str, scheme: str) -> None:
    path, ready = READ[name]
    page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
    specimens(page)
    page.goto(path)
    page.locator(ready).first.wait_for(state="attached")
    picture(page, f"shot-{name}-{scheme}", SIZES, full=True)


@pytest.mark.parametrize("language", ["de", "uk"])
@pytest.mark.parametrize("name", READ)
def test_other_languages(page: Page, name: str, language: str) -> None:
    path, ready = READ[name]
    specimens(page)
    page.goto(f"{path}{'&' if '?' in path else '?'}lang={language}")
    page.locator(ready).first.wait_for(state="attached")
    picture(page, f"shot-{name}-{language}", ["hand"], full=True)


@external_data
def test_photographs(page: Page) -> None:
    board = "squares=8x8&marker_ratio=0.75&dictionary=DICT_4X4_1000"
    page.goto(f"/photos/?{board}")
    page.locator("#files").set_input_files(sorted((data_dir() / "photos" / "charuco_640x480").glob("*.jpg")))
    page.locator("#status", has_text="The board was found in").wait_for()
    picture(page, "shot-photos-found", SIZES, full=True)
    page.locator("#camera").fill("LifeCam HD-3000")
    page.locator("#start").click()
    page.locator("#verdict").wait_for()
    picture(page, "shot-photos-done", SIZES, full=True)


def test_capture(page: Page) -> None:
    page.goto("/calibrate/?camera=HD+Pro+Webcam+C920+(046d:082d)&img_size=1280x720")
    page.locator("#wanted", has_text="No camera was found here").wait_for()
    picture(page, "shot-capture-before", SIZES)
    page.goto(HELD)
    page.locator("#undo:enabled").wait_for()
    page.locator(SHOWN_TARGET).first.wait_for()
    picture(page, "shot-capture-during", SIZES)
    page.goto(f"/calibrate/?{Truth().query(seed=3)}")
    done(page)
    picture(page, "shot-capture-done", SIZES)


def test_overlays(page: Page) -> None:
    page.goto("/ar/")
    page.locator("#camera option").first.wait_for(state="attached")
    picture(page, "shot-ar-before", SIZES)
    page.goto("/ar/?virtual=1&k1=-0.3&error=0")
    page.locator("#rms:not(:empty)").wait_for()
    for key, name in (("1", "matrix"), ("2", "rectified"), ("3", "distorted")):
        page.keyboard.press(key)
        page.locator(f"#stage[data-shown={name}]").wait_for()
        picture(page, f"shot-ar-{name}", SIZES)


@pytest.mark.parametrize("language", ["de", "uk"])
def test_capture_in_other_languages(page: Page, language: str) -> None:
    page.goto(f"/calibrate/?lang={language}")
    page.locator("#camera option").first.wait_for(state="attached")
    picture(page, f"shot-capture-before-{language}", ["hand"])
    page.goto(f"{HELD}&lang={language}")
    page.locator(SHOWN_TARGET).first.wait_for()
    picture(page, f"shot-capture-during-{language}", ["hand"])


def test_what_goes_wrong(context: BrowserContext) -> None:
    page = context.new_page()
    problem = {"title": "Forbidden", "status": 403, "detail": "The API token is not valid."}
    page.route(
        "**/v1/auth",
        lambda route: route.fulfill(status=403, json=problem, content_type="application/problem+json"),
    )
    page.goto(f"/calibrate/?{Truth().query()}")
    page.locator("#failed:not([hidden])").wait_for()
    picture(page, "shot-capture-failed", SIZES)


def picture_outcome(page: Page, name: str, sizes: Iterable[str]) -> None:
    for size in sizes:
        page.set_viewport_size(SIZES[size])
        page.locator("#outcome").evaluate("element => element.scrollIntoView({ block: 'center' })")
        picture(page, name, [size])


def test_how_a_lookup_ends(context: BrowserContext) -> None:
    for name, known in (("known", True), ("not-yet", False)):
        page = context.new_page()
        page.add_init_script(CAMERA)
        if known:
            answer(page, "**/v1/lookup", lambda: result() | {"calibrations": 7, "reliable": True})
        page.goto("/")
        page.locator("#look").click()
        words = "is ready to use" if known else "We don't know"
        page.locator("#outcome h3", has_text=words).wait_for()
        picture_outcome(page, f"shot-lookup-{name}", SIZES)
    page = context.new_page()  # where there is no camera
    for language, words in (("en", "No camera was found"), ("de", "keine Kamera"), ("uk", "Камери не")):
        page.goto(f"/?lang={language}")
        page.locator("#look").click()
        page.locator("#outcome .problem", has_text=words).wait_for()
        picture_outcome(page, f"shot-lookup-no-camera-{language}", SIZES if language == "en" else ["hand"])


def test_what_the_capture_says_of_what_happens(page: Page) -> None:
    page.goto(f"/calibrate/?{Truth().query(seed=3, error=0, fault='dark')}")
    page.locator("#instruction", has_text="Too dark").wait_for()
    picture(page, "shot-capture-diagnosis", SIZES)
    page.goto(HELD)
    page.locator("#undo:enabled").wait_for()
    page.locator("#stop").click()
    picture(page, "shot-capture-stop", SIZES)
    page.evaluate(UNPLUG)
    page.locator("#failed:not([hidden])").wait_for()
    picture(page, "shot-capture-kept", SIZES)
    page.goto("/calibrate/")
    page.locator("#interrupted:not([hidden])").wait_for()
    picture(page, "shot-capture-interrupted", SIZES)


def test_the_camera_is_not_there_yet(page: Page) -> None:
    page.add_init_script(UNANSWERED)
    page.goto("/calibrate/")
    page.locator("#start").click()
    page.locator("#opening:not([hidden])", has_text="allow it").wait_for()
    picture(page, "shot-capture-opening", SIZES)


def test_another_camera_than_was_asked_for(page: Page) -> None:
    page.goto(f"{HELD}&camera=HD+Pro+Webcam+C920+(046d:082d)")
    page.locator("#another:not([hidden])").wait_for()
    picture(page, "shot-capture-another", SIZES)


def test_a_device_that_is_turned(page: Page) -> None:
    page.goto(HELD)
    page.locator("#undo:enabled").wait_for()
    page.evaluate(TURN)
    page.locator("#notice", has_text="a separate calibration").wait_for()
    picture(page, "shot-capture-resized", SIZES)


def test_a_result_without_some_views(page: Page) -> None:
    specimens(page)
    less = result()
    less["report"]["views"] = [view for view in less["report"]["views"] if view["index"] not in {4, 5}]
    answer(page, "**/v1/calibrations/*?without=*", lambda: less | {"id": None})
    page.goto("/result/?id=x")
    page.locator("#tab-views").click()
    page.locator("#leave-these").click()
    page.locator(".trial").wait_for()
    picture(page, "shot-result-without", SIZES, full=True)
    page.locator("#result-views").scroll_into_view_if_needed()
    picture(page, "shot-result-without-views", SIZES)


def test_a_practice_is_said_to_be_one(page: Page) -> None:
    answer(page, "**/v1/calibrations/x", lambda: result() | {"camera": CAMERAS[-1][0]})
    page.goto("/result/?id=x")
    page.locator(".practice").wait_for()
    picture(page, "shot-result-practice", SIZES)


def test_without_the_network(context: BrowserContext) -> None:
    page = context.new_page()
    page.goto(HELD)
    page.locator("#undo:enabled").wait_for()
    no_network(page)
    page.locator("#counts", has_text=re.compile("[2-9] of [3-8] saved here")).wait_for()
    picture(page, "shot-capture-away", SIZES)


def test_the_board_alone(page: Page) -> None:
    page.goto("/board/?fill=1")
    page.locator("#frame.filling").wait_for()
    picture(page, "shot-board-filling", SIZES)
    page.goto("/board/?squares=12x12")
    page.locator("#columns").fill("40")
    page.locator("#board-problem:not(:empty)").wait_for()
    picture(page, "shot-board-impossible", SIZES, full=True)


@external_data
def test_what_photographs_lack(page: Page) -> None:
    page.goto("/photos/?squares=8x8&marker_ratio=0.75&dictionary=DICT_4X4_1000")
    some = sorted((data_dir() / "photos" / "charuco_640x480").glob("*.jpg"))[0]
    page.locator("#files").set_input_files(
        [
            FilePayload(name="1.jpg", mimeType="image/jpeg", buffer=some.read_bytes()),
            unreadable("IMG_0001.HEIC"),
        ]
    )
    page.locator("#status", has_text="The board was found in 1 of 1").wait_for()
    page.locator("#camera").fill("LifeCam HD-3000")
    page.locator("#start").click()
    page.locator("#wanted figure").wait_for()
    picture(page, "shot-photos-advice", SIZES, full=True)


def test_what_is_not_there(context: BrowserContext) -> None:
    page = context.new_page()
    for language in ("en", "de", "uk"):
        page.goto(f"/cameras/?key=c2.none&lang={language}")
        page.locator("#waiting .actions").wait_for()
        picture(page, f"shot-camera-none-{language}", ["hand"])
        page.goto(f"/result/?id=there-is-none&lang={language}")
        page.locator("#waiting .actions").wait_for()
        picture(page, f"shot-result-none-{language}", ["hand"])


def test_the_overlays_of_the_readme(page: Page) -> None:
    page.set_viewport_size({"width": 720, "height": 680})
    page.goto("/ar/?virtual=1&k1=-0.3&error=0")
    page.locator("#rms:not(:empty)").wait_for()
    halves = []
    for key, name in (("1", "matrix"), ("3", "distorted")):
        page.keyboard.press(key)
        page.locator(f"#stage[data-shown={name}]").wait_for()
        image = cv2.imdecode(np.frombuffer(page.locator("#stage").screenshot(), np.uint8), cv2.IMREAD_COLOR)
        assert image is not None
        halves.append(image)
    cv2.imwrite(str(OUTPUT / "readme-overlays.png"), np.hstack(halves))
