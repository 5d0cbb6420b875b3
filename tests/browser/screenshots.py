"""Pictures of every page and of a capture, left in tests/browser/output/ for people to look at.

Not a test by its name: `make test` passes over it. `make thorough` leaves pictures of all other states.
"""

from collections.abc import Iterable

import cv2
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page

from tests.helpers.browser.interruptions import SHOWN_TARGET, TURN, done
from tests.helpers.browser.pictures import SIZES, picture
from tests.helpers.browser.scenes import CAMERA, UNANSWERED
from tests.helpers.browser.site_pages import PAGES, prepare, visit
from tests.helpers.browser.specimens import VIRTUAL, answer, result
from tests.helpers.browser.truth import Truth

from .conftest import OUTPUT

HELD = f"/calibrate/?{Truth().query(seed=3)}&target_error=0.01&error=0"


@pytest.mark.parametrize("kind", ["light", "dark", "de", "uk"])
@pytest.mark.parametrize("name", PAGES)
def test_pages_one_reads(page: Page, name: str, kind: str) -> None:
    page.emulate_media(color_scheme="dark" if kind == "dark" else "light")
    session = prepare(page)
    visit(page, session, name, kind if kind in {"de", "uk"} else "en")
    picture(page, f"shot-{name}-{kind}", SIZES, full=True, check=False)


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


def test_a_practice_is_said_to_be_one(page: Page) -> None:
    answer(page, "**/v1/calibrations/x", lambda: result() | {"camera": VIRTUAL})
    page.goto("/result/?id=x")
    page.locator(".practice").wait_for()
    picture(page, "shot-result-practice", SIZES)


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
