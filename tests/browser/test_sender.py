"""The application that a visitor came from."""

import pytest
from playwright.sync_api import Page, expect

from tests.helpers.browser.pictures import picture
from tests.helpers.browser.scenes import BLIND_DETECTOR
from tests.helpers.browser.specimens import answer

ASKED = "camera=HD+Pro+Webcam+C920+(046d:082d)&img_size=640x480"
MODE = {"zoom": 0, "contributors": 3, "required": 5}
KNOWN = {
    "cameras": [
        {
            "key": "c2.x", "camera": "HD Pro Webcam C920", "platform": "Linux",
            "sizes": [
                MODE | {"img_size": [640, 480], "calibrations": 4, "agreeing": 3, "reliable": False},
                MODE | {"img_size": [1280, 720], "calibrations": 9, "agreeing": 9, "reliable": True},
            ],
        }
    ],
    "next": None,
}  # fmt: skip


def test_sender_is_named_and_one_click_away(page: Page) -> None:
    page.add_init_script(BLIND_DETECTOR)
    answer(page, "**/v1/cameras?*", lambda: KNOWN)
    page.goto(f"/calibrate/?{ASKED}&return_to=http://localhost:9000/app?a=b")
    sender = page.locator("#sender")
    expect(sender.locator("p").first).to_have_text(
        "localhost:9000 needs your camera's calibration (HD Pro Webcam C920 (046d:082d), 640 × 480). "
        "It takes about a minute. Then you return to localhost:9000."
    )
    expect(page.locator("#sender-known")).to_contain_text("2 more calibrations are needed")
    expect(page.locator("#go-back")).to_have_attribute("href", "http://localhost:9000/app?a=b")
    expect(page.locator("#wanted")).to_have_text("No camera was found here. Plug it in.")
    expect(page.locator("#camera"), "the virtual camera does not stand in for a real one").to_have_value("")
    picture(page, "capture-sender", ["hand"])
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.getElementById('start').getBoundingClientRect().bottom") < 780
    with page.expect_download() as paper:
        page.locator("#paper").click()
    assert paper.value.suggested_filename == "calibdb-board-letter.pdf"


@pytest.mark.thorough
def test_sender_without_a_result_is_told_before(page: Page) -> None:
    page.add_init_script(BLIND_DETECTOR)
    sender = page.locator("#sender")
    page.goto(f"/calibrate/?{ASKED}&return_to=http://app.example/")
    expect(sender).to_contain_text("this service may not hand the result to app.example")
    expect(page.locator("#go-back")).to_be_hidden()
    page.goto(f"/calibrate/?{ASKED}&return_to=javascript:alert(1)")
    expect(page.locator("#wanted")).to_contain_text("This page was opened for HD Pro Webcam C920")
    expect(sender).to_be_hidden()
