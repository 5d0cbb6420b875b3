"""Picture of the AR page's overlays for the README, left in tests/browser/output/.

Not a test by its name: `make test` passes over it.
"""

import cv2
import numpy as np
from playwright.sync_api import Page

from tests.helpers.browser.pictures import shot

from .conftest import OUTPUT


def test_the_overlays_of_the_readme(page: Page) -> None:
    OUTPUT.mkdir(exist_ok=True)
    page.set_viewport_size({"width": 720, "height": 680})
    page.goto("/ar/?virtual=1&k1=-0.3&error=0")
    page.locator("#rms:not(:empty)").wait_for()
    halves = []
    for key, name in (("1", "matrix"), ("3", "distorted")):
        page.keyboard.press(key)
        page.locator(f"#stage[data-shown={name}]").wait_for()
        halves.append(shot(page.locator("#stage")))
    cv2.imwrite(str(OUTPUT / "readme-overlays.png"), np.hstack(halves))
