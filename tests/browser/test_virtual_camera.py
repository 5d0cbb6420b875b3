"""The whole guided capture, hands-free, against a camera that is known."""

import json
import subprocess
import time
from pathlib import Path
from typing import Any

import httpx
from playwright.sync_api import Page

from .conftest import executable
from .truth import Truth, projection_errors

TRUTH = Truth()


def assert_true(calibration: dict[str, Any], views: int, seconds: float, where: str) -> None:
    errors = projection_errors(TRUTH, calibration)
    fx = calibration["camera_matrix"][0][0]
    print(
        f"{where}: {views} views, {seconds:.1f} s, fx {100 * (fx / TRUTH.fx - 1):+.3f} %, "
        f"projection error mean {errors.mean():.3f}, max {errors.max():.3f} px"
    )
    assert views <= 8
    assert abs(fx / TRUTH.fx - 1) < 0.005
    assert errors.mean() < 0.6


def test_chromium_from_the_first_click_to_the_result(page: Page, api: httpx.Client) -> None:
    sent: list[str] = []
    page.on("request", lambda request: sent.append(request.post_data or ""))
    states: list[dict[str, Any]] = []
    page.on(
        "response",
        lambda answer: states.append(answer.json()) if answer.url.endswith("/session/views") else None,
    )
    page.goto(f"/calibrate/?{TRUTH.query()}")
    start = time.monotonic()
    page.wait_for_selector("#done:not([hidden]), #failed:not([hidden])")
    seconds = time.monotonic() - start
    assert page.locator("#done").is_visible(), page.locator("#failure").text_content()
    calibration = json.loads(page.locator("#json").text_content() or "")
    views = int((page.locator("#counts").text_content() or "0").split()[0])
    assert views == len(states[-1]["views"])
    assert_true(calibration, views, seconds, "Chromium")

    assert page.locator("#verdict").is_visible()
    with page.expect_download() as download:
        page.locator("#download").click()
    saved = Path(download.value.path()).read_text()
    assert json.loads(saved) == calibration
    assert api.get(f"/calibrations/{calibration['id']}").json() == calibration

    # Corner positions leave the device, pictures never: nothing that was sent is near a picture's size.
    bodies = [body for body in sent if body]
    assert bodies
    assert max(map(len, bodies)) < 4096
    for body in bodies:
        assert set(json.loads(body)) <= {
            *("camera", "platform", "img_size", "zoom", "board", "distortion_model", "track", "index"),
            *("ids", "points"),
        }


def test_firefox_from_the_first_click_to_the_result(stack: str) -> None:
    address = f"{stack}/calibrate/?{TRUTH.query(seed=5)}"
    script = Path(__file__).with_name("firefox.mjs")
    run = subprocess.run(
        ["node", str(script), executable("firefox-esr"), address],
        capture_output=True,
        text=True,
        timeout=180,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    outcome = json.loads(run.stdout)
    assert outcome["failure"] == ""
    assert outcome["complaints"] == []
    views = int(outcome["counts"].split()[0])
    assert_true(outcome["calibration"], views, outcome["elapsed"], "Firefox")
