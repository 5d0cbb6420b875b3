"""A video file as the camera of getUserMedia."""

import json
from pathlib import Path

import numpy as np
from playwright.sync_api import Playwright, expect

from tests.helpers.browser.fake_camera import HEIGHT, WIDTH, board_seen, camera
from tests.helpers.browser.interruptions import stop


def test_first_view_and_lookup_through_a_real_camera(
    playwright: Playwright, stack: str, tmp_path: Path
) -> None:
    _, truth = board_seen()
    with camera(playwright, stack, tmp_path, rate=8) as page:
        page.goto("/calibrate/")
        page.locator("#camera option").nth(1).wait_for(state="attached")
        with page.expect_request("**/v1/session/views") as view:
            page.locator("#start").click()
        answer = view.value.response()
        assert answer is not None
        state = answer.json()
        sent = view.value.post_data_json
        mirrored = page.locator("#stage.mirrored").count()
        shown = page.locator("#sent-json").text_content() or ""
        assert state["accepted"], state["reason"]
        page.locator("#undo:enabled").wait_for()
        stop(page)

        page.goto("/")
        page.locator("#look").click()
        page.locator("#outcome a").click()
        expect(page.locator("#wanted")).to_contain_text(state["camera"])
    errors = np.linalg.norm(np.array(sent["points"]) - truth[sent["ids"]], axis=1)
    assert len(errors) == 40
    assert np.sqrt((errors**2).mean()) < 0.1
    assert state["img_size"] == [WIDTH, HEIGHT]
    assert state["camera"]
    assert mirrored == 1
    # Of the path by which this browser calls it, the service shows the file's name.
    assert state["camera"] in shown
    assert json.dumps(state["platform"]) in shown
