"""What happens to a capture in the middle of it, and what the page makes of that."""

import json
import re

from playwright.sync_api import BrowserContext, Page, Request

from .pictures import picture
from .truth import Truth

VIRTUAL = f"/calibrate/?{Truth().query(seed=3)}"
TURN = """() => {
  const canvas = document.querySelector(".virtual-camera");
  [canvas.width, canvas.height] = [canvas.height, canvas.width];
}"""
UNPLUG = "document.getElementById('video').srcObject.getVideoTracks()[0].dispatchEvent(new Event('ended'))"


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


def test_a_lost_camera_loses_no_views(page: Page) -> None:
    begun: list[str] = []
    page.on("request", lambda request: begun.append(request.url) if request.method == "POST" else None)
    page.goto(VIRTUAL)
    page.locator("#undo:enabled").wait_for()
    page.evaluate(UNPLUG)
    page.locator("#failed:not([hidden])").wait_for()
    assert page.locator("#failure").text_content() == "The camera was unplugged."
    assert re.fullmatch(
        r"(1 view is|\d views are) kept. Try again with the same camera to go on.",
        page.locator("#kept").text_content() or "",
    )
    picture(page, "capture-kept")
    before = int((page.locator("#counts").text_content() or "0").split()[0])
    page.locator("#again").click()
    page.locator("#controls:not([hidden])").wait_for()
    assert int((page.locator("#counts").text_content() or "0").split()[0]) >= before
    page.locator("#done:not([hidden])").wait_for()
    assert len([url for url in begun if url.endswith("/v1/session")]) == 1


def test_a_stop_that_would_lose_views_is_asked_for_twice(page: Page) -> None:
    page.goto(f"{VIRTUAL}&target_error=0.05")  # not reached in the time this takes
    page.locator("#undo:enabled").wait_for()
    page.locator("#stop").click()
    assert re.fullmatch(r"Stop and lose \d views?\?", page.locator("#stop").text_content() or "")
    assert page.locator("#controls").is_visible()
    picture(page, "capture-stop")
    page.locator("#stop", has_text=re.compile("^Stop$")).wait_for(timeout=10_000)
    page.locator("#stop").click()
    page.locator("#stop").click()
    page.locator("#welcome:not([hidden])").wait_for()


def test_waiting_for_the_service_is_said_and_can_be_ended(context: BrowserContext) -> None:
    page = context.new_page()  # what is refused here complains in the console
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url) if "/v1/" in request.url else None)
    page.route("**/v1/auth", lambda route: route.abort())
    page.goto(VIRTUAL)
    page.locator("#opening-text", has_text="connection to calibDB is lost. Trying again").wait_for()
    picture(page, "capture-offline")
    page.locator("#cancel").click()
    page.locator("#welcome:not([hidden])").wait_for()
    before = len(asked)
    page.wait_for_timeout(2_500)
    assert len(asked) == before
    assert page.locator("#welcome").is_visible()


def test_what_cannot_be_loaded_is_said_in_plain_words(context: BrowserContext) -> None:
    page = context.new_page()
    page.route("**/*.wasm", lambda route: route.abort())
    page.goto(VIRTUAL)
    page.locator(
        "#failure", has_text="The board detector could not be loaded. Check the connection"
    ).wait_for()
    page.route("**/config.json", lambda route: route.abort())
    page.goto("/")
    page.locator("#look").click()
    page.locator("#outcome p", has_text="calibDB cannot be reached. Check the connection").wait_for()
