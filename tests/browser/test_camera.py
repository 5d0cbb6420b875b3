"""The detector, and boards before the camera of getUserMedia."""

import json
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, Playwright, expect

from calibdb_client import Board
from tests.helpers.browser import stop_and_go
from tests.helpers.browser.fake_camera import SIZE, board_seen, camera
from tests.helpers.browser.frame_rate import COUNT_FRAMES
from tests.helpers.browser.interruptions import sessions, stop
from tests.helpers.browser.pictures import picture
from tests.helpers.browser.scripts import PLAIN, page_function
from tests.helpers.browser.truth import SMALL
from tests.helpers.browser.waiting import address, hear, listen
from tests.helpers.marks import thorough

DETECTIONS = page_function("watch_detector")
TROUBLES = page_function("diagnose")
#: three seconds of the camera's 8 per second; 8 to 13 were measured
MAX_FRAMES = 24
CHESSBOARD, CHARUCO = "10 × 7 chessboard", "8 × 8 ChArUco, DICT_4X4_50, markers 0.75"
SHOWN = {CHESSBOARD: Board((10, 7), kind="chessboard"), CHARUCO: Board((8, 8), 0.75)}
#: `tests/web/diagnosis.test.mjs` has those that are known from brightness or stripes
FAULTS: dict[str, dict[str, object]] = {
    "nothing": {},
    "blurred": {"fault": "blurred"},
    "mirrored": {"fault": "mirrored"},
    "far": {"z": 57},
    "wrong_board": {"board": {"dictionary": "DICT_6X6_250"}},
    "legacy": {"board": {"legacy": True}},
}


@pytest.mark.parametrize("frames", [20, *thorough(2_000)])
def test_detector_is_exact_and_keeps_its_memory(page: Page, frames: int) -> None:
    page.goto(PLAIN)
    seen = page.evaluate(DETECTIONS, frames)
    assert seen["full"]["ids"] == list(range(40))
    errors = np.linalg.norm(np.array(seen["full"]["points"]) - np.array(seen["truth"]), axis=1)
    rms = np.sqrt((errors**2).mean())
    assert rms < 0.1
    assert errors.max() < 0.3
    assert seen["memory"][-1] == seen["memory"][0], f"grows by {np.diff(seen['memory']).sum()} bytes"
    assert (seen["empty"]["ids"], seen["empty"]["markers"]) == ([], 0)
    assert seen["progress"][-1] == 1.0
    assert seen["progress"] == sorted(seen["progress"])


def test_each_trouble_is_known_from_the_picture(page: Page) -> None:
    page.goto(PLAIN)
    said = page.evaluate(TROUBLES, FAULTS)
    assert said == {name: None if name == "nothing" else name for name in FAULTS}


def test_first_view_and_lookup_through_a_real_camera(
    playwright: Playwright, stack: str, tmp_path: Path
) -> None:
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
    errors = np.linalg.norm(np.array(sent["points"]) - board_seen(Board())[1][sent["ids"]], axis=1)
    assert len(errors) == 40
    assert np.sqrt((errors**2).mean()) < 0.1
    assert tuple(state["img_size"]) == SIZE
    assert state["camera"]
    assert mirrored == 1
    # Of the path by which this browser calls it, the service shows the file's name.
    assert state["camera"] in shown
    assert json.dumps(state["platform"]) in shown


@pytest.mark.parametrize("words", [*thorough(CHESSBOARD), CHARUCO])
def test_another_board_is_suggested_after_few_frames_and_used(
    playwright: Playwright, stack: str, tmp_path: Path, words: str
) -> None:
    with camera(playwright, stack, tmp_path, stop_and_go.RATE, SHOWN[words]) as page:
        page.add_init_script(COUNT_FRAMES)
        listen(page)
        page.goto("/calibrate/")
        page.locator("#start").click()
        page.locator("#instruction", has_text="This is a different board").wait_for()
        expect(page.locator("#remedy")).to_contain_text(words)
        texts = page.evaluate("window.said.instruction")
        page.locator("#right-board").click()
        expect(page.locator("#no-board svg path")).to_be_visible()
        picture(page, "capture-different-board", ["hand"])
        page.locator("#use-board").click()
        hear(page, "notice", f"This board is used now: {words[:5]}")
        page.locator("#undo:enabled").wait_for()
        assert f"squares={words[0]}" in address(page)
    assert not [text for text, _ in texts if "Move closer" in text]
    assert texts[-1][1] - texts[0][1] <= MAX_FRAMES


@pytest.mark.thorough
def test_a_board_of_the_older_layout_is_recognised(page: Page) -> None:
    begun = sessions(page)
    listen(page)
    page.goto(f"/calibrate/?{SMALL.query(error=0, shown_legacy='true')}")
    hear(page, "notice", "older layout")
    page.locator("#undo:enabled").wait_for()
    boards = [request.post_data_json["board"] for request in begun]
    assert [board["legacy"] for board in boards] == [False, True]
