"""Pictures of every page and of a capture, left in tests/browser/output/ for people to look at.

Not a test by its name: `make test` passes over it. `make thorough` leaves pictures of all other states.
"""

import cv2
import numpy as np
import pytest
from playwright.sync_api import Page

from tests.helpers.browser.interruptions import SHOWN_TARGET, done
from tests.helpers.browser.pictures import SIZES, picture, shot
from tests.helpers.browser.site_pages import PAGES, prepare, visit
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


def test_the_overlays_of_the_readme(page: Page) -> None:
    page.set_viewport_size({"width": 720, "height": 680})
    page.goto("/ar/?virtual=1&k1=-0.3&error=0")
    page.locator("#rms:not(:empty)").wait_for()
    halves = []
    for key, name in (("1", "matrix"), ("3", "distorted")):
        page.keyboard.press(key)
        page.locator(f"#stage[data-shown={name}]").wait_for()
        halves.append(shot(page.locator("#stage")))
    cv2.imwrite(str(OUTPUT / "readme-overlays.png"), np.hstack(halves))
