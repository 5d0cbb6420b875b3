"""A capture in all its states."""

import json
from collections.abc import Iterable
from typing import Any
from urllib.parse import urlsplit

import httpx
import pytest
from playwright.sync_api import Page, Request, Route, expect

from tests.helpers.browser.interruptions import (
    ENDLESS,
    HIDE,
    sessions,
    views,
    wait_for_views,
)
from tests.helpers.browser.pictures import picture, violations
from tests.helpers.browser.scripts import page_function
from tests.helpers.browser.waiting import address, until

from ..conftest import THOROUGH

# From the brand to the text, px; how far the sheet scrolls within the window; whether the window does.
READ_AS_A_PAGE = """() => {
  const left = (selector) => document.querySelector(selector).getBoundingClientRect().left;
  const [sheet, page] = [document.getElementById("done"), document.documentElement];
  const shift = Math.round(left("#done .practice") - left(".brand"));
  return [shift, sheet.scrollHeight - sheet.clientHeight, page.scrollHeight > innerHeight];
}"""
#: in the picture; on a busy machine as the plain outline for slow devices
SHOWN_TARGET = "#stage:not(.plain) #overlay:not([hidden]), #stage.plain #target[points*=',']"
# Hidden at once when a target is in the picture: a quick hand is soon there.
HIDE_WITH_TARGET = f"""() => new Promise((done) => {{
  const stage = document.getElementById("stage");
  const observer = new MutationObserver(() => look());
  const look = () => {{
    if (![...document.querySelectorAll("{SHOWN_TARGET}")].some((each) => each.checkVisibility())) return;
    observer.disconnect();
    ({HIDE})(true);
    done();
  }};
  observer.observe(stage, {{ subtree: true, attributes: true }});
  look();
}})"""
TRACK = "document.getElementById('video').srcObject.getTracks()[0].readyState"
FRAMES = page_function("count_frames")


KEYPOINTS = {"index", "ids", "points"}
SESSION = {"camera", "platform", "img_size", "zoom", "board", "distortion_model", "track", "target_error"}


def assert_only_keypoints(sent: Iterable[Request]) -> None:
    """Assert that a page sends only GETs, start and end of a session, and corner positions."""
    views = 0
    for request in sent:
        if request.method == "GET":
            assert not request.post_data_buffer
            continue
        assert request.method == "POST", request.method
        path = urlsplit(request.url).path
        body = json.loads(request.post_data or "null")
        if path in ("/v1/auth", "/v1/session/finish"):
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


def done(page: Page) -> None:
    """Wait for a capture's result with its report."""
    page.locator("#done:not([hidden])").wait_for()
    page.locator("#done .views li").first.wait_for(state="attached")


def published_corners(page: Page, api: httpx.Client) -> list[Any]:
    page.locator(".views li").first.wait_for(state="attached")
    answer = api.get(f"/calibrations/{address(page).split('id=')[1]}", params={"format": "photonvision"})
    return [view["locationInImageSpace"][0] for view in answer.raise_for_status().json()["observations"]]


def press_at(page: Page, selector: str) -> None:
    focused = "(selector) => document.activeElement.matches(selector)"
    for _ in range(40):
        page.keyboard.press("Tab")
        if page.evaluate(focused, selector):
            break
    assert page.evaluate(focused, selector), selector
    page.keyboard.press("Enter")


MAX_SHIFT = 0.02
# [ms, shift] of what moves while views are taken, but for what follows a key
SHIFTS = """window.shifts = [];
new PerformanceObserver((list) => {
  if (document.getElementById("reticle").hidden) return;
  for (const { startTime, value, hadRecentInput } of list.getEntries())
    if (!hadRecentInput) window.shifts.push([startTime, value]);
}).observe({ type: "layout-shift", buffered: true });"""


def test_capture_in_all_its_states_sends_keypoints_only(page: Page, api: httpx.Client) -> None:
    sent: list[Request] = []
    page.on("request", lambda request: sent.append(request))
    page.on("websocket", lambda socket: pytest.fail(f"a socket to {socket.url}"))
    page.emulate_media(reduced_motion="no-preference")
    page.set_viewport_size({"width": 390, "height": 844})
    # The capture must not be over before it is looked at.
    page.add_init_script(SHIFTS)
    page.goto(f"{ENDLESS.replace('virtual=1&', '')}&camera=C920&return_to=https://app.example/")
    page.locator("#start-virtual:visible").wait_for()
    press_at(page, "#start-virtual")
    page.locator("#overlay[src^='blob:']:not([hidden])").wait_for(state="attached")
    wait_for_views(page, 4)
    page.evaluate(HIDE_WITH_TARGET)
    shifts = page.evaluate("window.shifts")
    assert shifts
    within_5_s = [sum(value for at, value in shifts if 0 <= at - start <= 5000) for start, _ in shifts]
    assert max(within_5_s) < MAX_SHIFT
    taken = views(page)
    expect(page.locator("#film .taken img")).to_have_count(taken)
    expect(page.locator("#film .next polygon")).to_have_count(1)
    expect(page.locator("#film > i")).to_have_count(taken + 1)
    picture(page, "capture-during")
    page.evaluate(HIDE, False)
    press_at(page, "#finish")
    done(page)
    expect(page.locator("#result-name")).to_be_focused()
    assert len(published_corners(page, api)) >= 4
    expect(page.locator("#practice-kept")).to_contain_text("app.example does not get a practice result")
    expect(page.locator("#go-on-really")).to_be_visible()
    expect(page.locator("#own-camera")).to_have_count(0)
    assert "return_to" not in address(page)
    expect(page.locator("#consent"), "practice is nobody's data").to_be_hidden()
    picture(page, "capture-done")
    expect(page.locator("header nav > a", has_text="Cameras")).to_have_attribute("href", "../cameras/")
    expect(page.locator("header nav > a", has_text="Cameras")).to_be_visible()
    board = page.locator("#done .scene .board path").first
    seen = board.get_attribute("d")
    page.locator("#done .scene-view input").first.focus()
    page.keyboard.press("ArrowRight")
    assert board.get_attribute("d") != seen
    expect(page.locator("#done .scene-view .fields")).to_have_css("opacity", "1")
    page.set_viewport_size({"width": 1440, "height": 900})
    assert page.evaluate(FRAMES) == 2
    assert page.locator(".compare").evaluate("stage => stage.getBoundingClientRect().bottom") < 900
    page.locator("#turn-off").click()
    expect(page.locator("#turn-off")).to_have_count(0)
    assert page.evaluate(TRACK) == "ended", "the camera's light is off"
    assert page.evaluate("document.activeElement.id") == "trial-picture"
    assert page.evaluate(READ_AS_A_PAGE) == [0, 0, True]
    expect(page.locator("#summary")).to_contain_text("practice run")
    expect(page.locator("#practice")).to_contain_text("Practice run")
    expect(page.locator("#done .another")).to_contain_text("Expected: C920")
    assert_only_keypoints(sent)
    if THOROUGH:
        expect_to_continue_without_a_view(page, api)


def expect_to_continue_without_a_view(page: Page, api: httpx.Client) -> None:
    before = published_corners(page, api)
    page.locator("#tab-views").click()
    assert page.locator(".views image").count() == len(before)
    page.locator("#view-1-out").click()
    page.locator(".trial").wait_for()
    page.locator(".views").scroll_into_view_if_needed()
    assert violations(page) == []
    first = address(page)
    page.locator("#go-on-without").click()
    reports: list[Route] = []
    page.route("**/v1/calibrations/*", lambda route: reports.append(route))
    page.locator("#finish").click()
    until(page, lambda: address(page) != first and "/result/?id=" in address(page))
    page.locator("#download").focus()
    until(page, lambda: reports)
    for route in reports:
        route.continue_()
    page.unroute("**/v1/calibrations/*")
    done(page)
    expect(page.locator("#download:focus"), "the report leaves the focus where it is").to_have_count(1)
    after = published_corners(page, api)
    assert after[0] == before[0], "the views that are left are not taken again"
    assert before[1] not in after
    assert len(after) >= 4
    begun = sessions(page)
    page.locator(".more > summary").click()
    page.locator("#once-more").click()
    until(page, lambda: begun)
    page.locator("#controls:not([hidden])").wait_for()
    assert "/calibrate/?" in address(page)
