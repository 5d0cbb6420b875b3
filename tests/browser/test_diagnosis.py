"""Diagnosis of bad pictures."""

import pytest
from playwright.sync_api import Page, expect

from tests.helpers.browser.interruptions import sessions
from tests.helpers.browser.pictures import picture
from tests.helpers.browser.scripts import PLAIN, page_function
from tests.helpers.browser.truth import SMALL
from tests.helpers.browser.waiting import address, hear, listen

from ..conftest import THOROUGH


def capture_page(**more: object) -> str:
    return f"/calibrate/?{SMALL.query(error=0, **more)}"


WATCH = page_function("diagnose")


FAULTS: dict[str, dict[str, object]] = {
    "nothing": {},
    "blurred": {"fault": "blurred"},
    "mirrored": {"fault": "mirrored"},
    "far": {"z": 57},
    "wrong_board": {"board": {"dictionary": "DICT_6X6_250"}},
    "legacy": {"board": {"legacy": True}},
}
#: known from brightness or stripes, of which `tests/web/diagnosis.test.mjs` has the thresholds
MORE_FAULTS: dict[str, dict[str, object]] = {
    "dark": {"fault": "dark"},
    "bright": {"fault": "bright"},
    "moire": {"fault": "moire"},
}


def test_each_trouble_is_known_from_the_picture(page: Page) -> None:
    faults = FAULTS | MORE_FAULTS if THOROUGH else FAULTS
    page.goto(PLAIN)
    said = page.evaluate(WATCH, faults)
    assert said == {name: None if name == "nothing" else name for name in faults}


@pytest.mark.thorough
def test_a_board_of_the_older_layout_is_recognised(page: Page) -> None:
    begun = sessions(page)
    listen(page)
    page.goto(capture_page(shown_legacy="true"))
    hear(page, "notice", "older layout")
    page.locator("#undo:enabled").wait_for()
    boards = [request.post_data_json["board"] for request in begun]
    assert [board["legacy"] for board in boards] == [False, True]


@pytest.mark.thorough
def test_a_different_board_can_be_used(page: Page) -> None:
    listen(page)
    page.goto(capture_page(shown_dictionary="DICT_5X5_100"))
    page.locator("#instruction", has_text="This is a different board").wait_for()
    expect(page.locator("#remedy")).to_contain_text("DICT_5X5_50")
    page.locator("#right-board").click()
    expect(page.locator("#no-board svg path")).to_be_visible()
    picture(page, "capture-different-board", ["hand"])
    page.locator("#use-board").click()
    hear(page, "notice", "This board is used now: 9 × 6")
    page.locator("#undo:enabled").wait_for()
    assert "dictionary=DICT_5X5_50" in address(page)
