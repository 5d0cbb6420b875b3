"""What happens to a capture in the middle of it, and what the page makes of that."""

import json

from playwright.sync_api import Page, Request

from .truth import Truth

VIRTUAL = f"/calibrate/?{Truth().query(seed=3)}"
TURN = """() => {
  const canvas = document.querySelector(".virtual-camera");
  [canvas.width, canvas.height] = [canvas.height, canvas.width];
}"""


def test_a_turned_device_ends_the_capture_and_sends_nothing_more(page: Page) -> None:
    sent: list[Request] = []
    page.on(
        "request",
        lambda request: sent.append(request) if request.url.endswith("/session/views") else None,
    )
    page.goto(VIRTUAL)
    page.locator("#undo:enabled").wait_for()
    page.evaluate(TURN)
    page.locator("#failed:not([hidden])").wait_for()
    assert "size changed" in (page.locator("#failure").text_content() or "")
    before = len(sent)
    page.wait_for_timeout(2_500)
    assert len(sent) == before
    for view in sent:  # all within the upright picture
        assert all(x < 1280 and y < 720 for x, y in json.loads(view.post_data or "")["points"])
    assert page.locator(".virtual-camera").count() == 0, "the camera is let go"
