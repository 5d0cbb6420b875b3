"""The whole guided capture, hands-free: a camera that is known, a board in hands that are not perfect."""

import json
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, Request

from tests.helpers.browser.firefox import driven
from tests.helpers.browser.frame_rate import WATCH
from tests.helpers.browser.interruptions import views
from tests.helpers.browser.truth import SMALL, Truth, projection_errors
from tests.helpers.browser.waiting import address
from tests.helpers.marks import thorough

from .test_lookup import expect_known_after_five

ROOT = Path(__file__).resolve().parents[2]

RATE = 15  # frames/s, of a webcam in poor light
KEYPOINTS = {"index", "ids", "points"}
SESSION = {"camera", "platform", "img_size", "zoom", "board", "distortion_model", "track", "target_error"}


def assert_true(
    calibration: dict[str, Any], views: int, seconds: float, frames: int, where: str, truth: Truth = SMALL
) -> None:
    """A camera is as it was made; its capture took as long as the frames of 40 seconds."""
    errors = projection_errors(truth, calibration)
    fx = calibration["camera_matrix"][0][0]
    print(
        f"{where}: {views} views, {seconds:.1f} s, {frames} frames, fx {100 * (fx / truth.fx - 1):+.3f} %, "
        f"projection error mean {errors.mean():.3f}, max {errors.max():.3f} px"
    )
    assert views <= 6
    assert frames >= 5 * views  # of one that is held still there are several
    assert min(seconds, frames / RATE) <= 40  # a machine that looks at fewer has more time
    assert errors.mean() < 0.4 * truth.size[0] / 1280


def assert_only_keypoints(sent: list[Request]) -> None:
    """Assert that GETs, the opening of a session and corner positions leave the page, never a picture."""
    views = 0
    for request in sent:
        if request.method == "GET":
            assert not request.post_data_buffer
            continue
        assert request.method == "POST", request.method
        path = urlsplit(request.url).path
        body = json.loads(request.post_data or "null")
        if path == "/v1/auth":
            assert body is None
        elif path == "/v1/session":
            assert set(body) <= SESSION
            assert all(isinstance(value, (str, int, float)) for value in body["track"].values())
        else:
            assert path == "/v1/session/views"
            assert set(body) == KEYPOINTS
            assert len(body["ids"]) == len(body["points"]) <= 40
            assert all(len(point) == 2 for point in body["points"])
            assert len(request.post_data or "") < 4096
            views += 1
    assert views >= 4


@pytest.mark.parametrize("truth", [SMALL, *thorough(Truth())], ids=["640", "1280"])
def test_chromium_hands_free_with_nothing_but_keypoints_until_the_camera_is_known(
    page: Page, api: httpx.Client, stack: str, truth: Truth
) -> None:
    sent: list[Request] = []
    page.on("request", lambda request: sent.append(request))
    page.on("websocket", lambda socket: pytest.fail(f"a socket to {socket.url}"))
    page.add_init_script(WATCH)
    page.goto(f"/calibrate/?{truth.query(hand='person', rate=RATE, k3=1e-6)}")
    page.wait_for_selector("#done:not([hidden]), #failed:not([hidden])")
    seconds, frames = page.evaluate("[performance.now() / 1000, window.pace.frames]")
    assert page.locator("#done").is_visible(), page.locator("#failure").text_content()
    stored = api.get(f"/calibrations/{address(page).split('id=')[1]}").json()
    assert_true(stored, views(page), seconds, frames, "Chromium", truth)
    assert_only_keypoints(sent)
    expect_known_after_five(page, api, stack, stored, truth)


@pytest.mark.alone
def test_firefox_hands_free(stack: str) -> None:
    there = f"{stack}/calibrate/?{SMALL.query(seed=5, hand='person', rate=RATE)}"
    script = ROOT / "tests/helpers/browser/firefox.mjs"
    outcome = driven(script, there)
    assert outcome["failure"] == ""
    count = int(outcome["counts"])
    assert_true(outcome["calibration"], count, *outcome["taken"], "Firefox")


@pytest.mark.thorough
def test_who_trembles_who_is_slow_and_who_goes_the_wrong_way_finishes_too(context: BrowserContext) -> None:
    pages = {}
    for seed, hand in enumerate(("shaky", "slow", "wrong")):
        page = pages[hand] = context.new_page()
        # Another camera each: one that is calibrated in two tabs at once is refused in the second.
        page.goto(f"/calibrate/?{SMALL.query(hand=hand, rate=RATE, seed=seed, k3=seed * 1e-6)}")
    for hand, page in pages.items():
        page.bring_to_front()
        page.wait_for_selector("#done:not([hidden]), #failed:not([hidden])")
        assert page.locator("#done").is_visible(), page.locator("#failure").text_content()
        errors = projection_errors(SMALL, json.loads(page.locator("#json").text_content() or ""))
        print(
            f"{hand}: {page.locator('#counts').text_content()}, projection error mean {errors.mean():.3f} px"
        )
        assert np.mean(errors) < 0.4
