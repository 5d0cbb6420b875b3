"""The camera of the AR page."""

from typing import Any

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.interruptions import UNPLUG
from tests.helpers.browser.scenes import BLIND_DETECTOR, LISTED_LATE, PLUG, PLUGGED
from tests.helpers.browser.specimens import answer, result
from tests.helpers.browser.waiting import until
from tests.helpers.marks import thorough

from .test_ar import WEBCAM

NO_PICTURE = """
  navigator.mediaDevices.getUserMedia = async () =>
    Object.assign(document.createElement("canvas"), { width: 1280, height: 720 }).captureStream(0);
"""


def known() -> dict[str, Any]:
    return result() | {"calibrations": 7, "reliable": True, "exact_size": True}


def test_requested_camera_is_opened_from_a_late_list_and_reopened(page: Page) -> None:
    answer(page, "**/v1/lookup", known)
    page.add_init_script(PLUGGED + LISTED_LATE + BLIND_DETECTOR)
    page.goto("/ar/?camera=HD+Pro+Webcam+C920+(046d:082d)&lang=en")
    page.locator("#start").click()
    page.evaluate("window.answer()")
    page.locator("#instruction:not(:empty)").wait_for()
    assert page.evaluate("window.asked.deviceId") == {"exact": "c920"}
    expect(page.locator("#facts")).to_contain_text("from calibDB")
    expect(page.locator("#move")).to_be_hidden()
    page.evaluate(PLUG, False)
    page.evaluate(UNPLUG)
    page.locator("#failure", has_text="this page continues automatically").wait_for()
    page.evaluate("window.asked = null")
    page.evaluate(PLUG, True)
    page.locator("#instruction:not(:empty)").wait_for()
    assert page.evaluate("window.asked.deviceId") == {"exact": "c920"}


@pytest.mark.parametrize(
    ("address", "where"),
    [("/examples/three/", "#problem"), *thorough(("/ar/", "#failure"), ("/calibrate/", "#failure"))],
)
def test_without_a_picture_it_is_said_to_send_none(page: Page, address: str, where: str) -> None:
    page.clock.install()
    page.add_init_script(WEBCAM + NO_PICTURE + BLIND_DETECTOR)
    page.goto(address)
    page.locator("#start").click()

    def said() -> bool:
        page.clock.run_for(5_000)
        return "The camera is open but sends no picture." in (page.locator(where).text_content() or "")

    until(page, said)


def test_a_link_to_a_result_that_is_gone_asks_calibdb(context: BrowserContext) -> None:
    page = context.new_page()
    page.add_init_script(WEBCAM + BLIND_DETECTOR)
    page.route("**/v1/calibrations/**", lambda route: route.fulfill(status=410, json={"detail": "withdrawn"}))
    answer(page, "**/v1/lookup", known)
    page.goto("/ar/#calibration=gone")
    page.locator("#facts", has_text="from calibDB").wait_for()
