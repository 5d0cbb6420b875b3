"""Hands-free captures of the simulated camera."""

import json
from typing import Any

import httpx
import pytest
from playwright.sync_api import Page

from calibsolver import Camera
from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.frame_rate import COUNT_FRAMES
from tests.helpers.browser.interruptions import views
from tests.helpers.browser.truth import SMALL, Truth
from tests.helpers.browser.waiting import address
from tests.helpers.marks import thorough
from tests.helpers.solver.synthetic import projection_error

from ..conftest import THOROUGH

RATE = 10 if THOROUGH else 5  # frames/s, of a webcam in poor light
HAND = "person" if THOROUGH else "quick"


def assert_true(
    calibration: dict[str, Any], views: int, seconds: float, frames: int, where: str, truth: Truth = SMALL
) -> None:
    """A camera is as it was made; its capture took as long as the frames of 40 seconds."""
    errors = projection_error(truth.camera, Camera.from_record(calibration))
    fx = calibration["camera_matrix"][0][0]
    print(
        f"{where}: {views} views, {seconds:.1f} s, {frames} frames, fx {100 * (fx / truth.fx - 1):+.3f} %, "
        f"projection error mean {errors.mean():.3f}, max {errors.max():.3f} px"
    )
    assert views <= 6
    assert frames >= 5 * views  # of one that is held still there are several
    assert min(seconds, frames / RATE) <= 40  # a machine that looks at fewer has more time
    assert errors.mean() < 0.4 * truth.size[0] / 1280


@pytest.mark.parametrize("truth", [SMALL, *thorough(Truth())], ids=["640", "1280"])
def test_hands_free_in_chromium(page: Page, api: httpx.Client, truth: Truth) -> None:
    page.add_init_script(COUNT_FRAMES)
    page.goto(f"/calibrate/?{truth.query(hand='person', rate=RATE, k3=1e-6)}")
    page.wait_for_selector("#done:not([hidden]), #failed:not([hidden])")
    seconds, frames = page.evaluate("[performance.now() / 1000, window.looks]")
    assert page.locator("#done").is_visible(), page.locator("#failure").text_content()
    stored = api.get(f"/calibrations/{address(page).split('id=')[1]}").json()
    assert_true(stored, views(page), seconds, frames, "Chromium", truth)


ENDED = """async () => {
  const [done, failed] = ["done", "failed"].map((id) => document.getElementById(id));
  while (done.hidden && failed.hidden) await new Promise((next) => setTimeout(next, 50));
  const taken = [performance.now() / 1000, window.looks];
  const [failure, json] = ["failure", "json"].map((id) => document.getElementById(id).textContent.trim());
  return { taken, failure, json, count: Number(document.getElementById("counts").dataset.taken) };
}"""


def test_hands_free_in_firefox(stack: str, in_firefox: InFirefox) -> None:
    there = f"{stack}/calibrate/?{SMALL.query(seed=5, hand=HAND, rate=RATE)}"
    outcome = in_firefox(there, ENDED, COUNT_FRAMES, size=(480, 480))
    assert outcome["failure"] == ""
    assert_true(json.loads(outcome["json"]), outcome["count"], *outcome["taken"], "Firefox")
