"""The overlay page's camera: asked for by name, pulled out, plugged in again, and without a picture."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.scenes import BLIND_DETECTOR
from tests.helpers.browser.specimens import answer, result
from tests.helpers.browser.waiting import until
from tests.helpers.marks import thorough

from .test_ar import WEBCAM

#: one camera that is there or not, and what was asked of it
PLUGGED = f"""{WEBCAM}
  Object.assign(window, {{ there: true }});
  const {{ enumerateDevices: list, getUserMedia: give }} = navigator.mediaDevices;
  navigator.mediaDevices.enumerateDevices = async () => window.there ? list() : [];
  navigator.mediaDevices.getUserMedia = async ({{ video }}) => {{
    window.asked = video;
    return window.stream = await give();
  }};
"""
LATE = """
  const { enumerateDevices: now } = navigator.mediaDevices;
  const listed = new Promise((resolve) => window.answer = resolve);
  navigator.mediaDevices.enumerateDevices = () => listed.then(now);
"""
NO_PICTURE = """
  navigator.mediaDevices.getUserMedia = async () =>
    Object.assign(document.createElement("canvas"), { width: 1280, height: 720 }).captureStream(0);
"""
PULL = """() => {
  window.there = false;
  const [track] = window.stream.getTracks();
  track.stop();
  track.dispatchEvent(new Event("ended"));
  navigator.mediaDevices.dispatchEvent(new Event("devicechange"));
}"""
PLUG = """() => {
  window.there = true;
  navigator.mediaDevices.dispatchEvent(new Event("devicechange"));
}"""


def known() -> dict[str, Any]:
    return result() | {"calibrations": 7, "reliable": True, "exact_size": True}


def test_requested_camera_is_opened_from_a_late_list_and_reopened(page: Page) -> None:
    answer(page, "**/v1/lookup", known)
    page.add_init_script(PLUGGED + LATE + BLIND_DETECTOR)
    page.goto("/ar/?camera=Overlay+Test+Camera+(1234:0a12)&lang=en")
    page.locator("#start").click()
    page.evaluate("window.answer()")
    page.locator("#instruction:not(:empty)").wait_for()
    assert page.evaluate("window.asked.deviceId") == {"exact": "c920"}
    expect(page.locator("#facts")).to_contain_text("from calibDB")
    expect(page.locator("#move")).to_be_hidden()
    page.evaluate(PULL)
    page.locator("#failure", has_text="this page continues automatically").wait_for()
    page.evaluate("window.asked = null")
    page.evaluate(PLUG)
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
