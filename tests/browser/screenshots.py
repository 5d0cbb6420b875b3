"""Pictures of every page in every state, to be looked at: `make screenshots`, into tests/browser/output/.

Not a test by its name, so that `make test` passes over it; the tests hold the same states to what must hold.
"""

from __future__ import annotations

import pytest
from playwright.sync_api import BrowserContext, Page

from tests.data import data_dir

from .pictures import SIZES, picture
from .specimens import answer, camera, cameras, result
from .truth import Truth

READ = {
    "landing": ("/", "#lens polyline"),
    "board": ("/board/", "#papers a"),
    "photos": ("/photos/", "#board:not(:empty)"),
    "import": ("/import/", "#model option"),
    "cameras": ("/cameras/", "#found li"),
    "camera": ("/cameras/?key=c2.specimen", "#camera-name"),
    "result": ("/result/?id=x", "#verdict"),
}
HELD = f"/calibrate/?{Truth().query(seed=3)}&target_error=0.05&error=0"


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
    page.locator("#wanted").wait_for()
    picture(page, "shot-capture-before", SIZES)
    page.goto(HELD)
    page.locator("#undo:enabled").wait_for()
    page.locator("#overlay:not([hidden])").wait_for()
    picture(page, "shot-capture-during", SIZES)
    page.goto(f"/calibrate/?{Truth().query(seed=3)}")
    page.locator("#done:not([hidden])").wait_for()
    page.locator(".views li").first.wait_for()
    picture(page, "shot-capture-done", SIZES)


@pytest.mark.parametrize("language", ["de", "uk"])
def test_capture_in_other_languages(page: Page, language: str) -> None:
    page.goto(f"/calibrate/?lang={language}")
    page.locator("#camera option").first.wait_for(state="attached")
    picture(page, f"shot-capture-before-{language}", ["hand"])
    page.goto(f"{HELD}&lang={language}")
    page.locator("#overlay:not([hidden])").wait_for()
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
    page.goto("/result/?id=there-is-none")
    page.locator("#status", has_text="no calibration").wait_for()
    picture(page, "shot-result-none", ["hand"])
