"""Interruptions of a capture, other tabs: no captured view is lost."""

import re
import time

import pytest
from playwright.sync_api import BrowserContext, Page, Request, Route, expect

from tests.helpers.browser.interruptions import (
    ENDLESS,
    HIDE,
    UNPLUG,
    VIRTUAL,
    sessions,
    stop,
    views,
    wait_for_views,
)
from tests.helpers.browser.pictures import picture
from tests.helpers.browser.scripts import PLAIN
from tests.helpers.browser.waiting import address, hear, heard, listen, requests_within, until

from ..conftest import THOROUGH

TURN = """() => {
  const canvas = document.querySelector(".virtual-camera");
  [canvas.width, canvas.height] = [canvas.height, canvas.width];
}"""
WORKERS = """
  window.workers = [];
  window.Worker = class extends Worker {
    constructor(url, options) { super(url, options); window.workers.push([String(url), this]); }
  };
"""
KILL = (
    "window.workers.filter(([url]) => url.includes('detector')).forEach(([, worker]) => worker.terminate())"
)
FULL = """
  IDBObjectStore.prototype.put = () => { throw new DOMException("no room", "QuotaExceededError"); };
"""
# As soon as it has a view: the service may end the capture with the next ones.
UNPLUG_WITH_A_VIEW = f"""() => new Promise((done) => {{
  const button = document.getElementById("undo");
  const isReady = () => !button.disabled && button.checkVisibility();
  const look = () => isReady() ? done({UNPLUG}) : requestAnimationFrame(look);
  look();
}})"""


@pytest.mark.thorough
def test_a_turned_device_gets_a_calibration_of_its_own(page: Page) -> None:
    begun = sessions(page)
    sent: list[tuple[int, Request]] = []
    page.on(
        "request",
        lambda request: (
            sent.append((len(begun), request)) if request.url.endswith("/session/views") else None
        ),
    )
    listen(page)
    page.goto(ENDLESS)
    page.locator("#undo:enabled").wait_for()
    page.evaluate(TURN)
    hear(page, "notice", "a separate calibration")
    assert [request.post_data_json["img_size"] for request in begun] == [
        [640, 360],
        [360, 640],
    ]
    for session, view in sent:  # nothing of one picture goes to the other's session
        assert session == 1
        assert all(x < 640 and y < 360 for x, y in view.post_data_json["points"])
    expect(page.locator(".virtual-camera")).to_have_count(1)


def test_no_interruption_loses_views(
    context: BrowserContext,
) -> None:
    page = context.new_page()  # Chromium complains of the frame that died with the worker, and of an outage
    page.add_init_script(WORKERS)
    begun = sessions(page)
    listen(page)
    page.goto(ENDLESS)
    page.locator("#undo:enabled").wait_for()
    page.locator("#stop").dblclick()
    hear(page, "stop", r"^Stop\?$")
    hear(page, "notice", r"^Press again to stop and lose \d views?\.$")
    expect(page.locator("#controls")).to_be_visible()
    page.evaluate(HIDE, True)  # frames that the page does not look at
    picture(page, "capture-stop", ["hand"], check=THOROUGH)
    page.evaluate(HIDE, False)

    page.evaluate(KILL)
    hear(page, "instruction", "Restarting the board detector")
    wait_for_views(page, views(page) + 1)
    page.locator("#stop", has_text=re.compile("^Stop$")).wait_for()

    page.evaluate(UNPLUG_WITH_A_VIEW)
    page.locator("#failed:not([hidden])").wait_for()
    expect(page.locator("#failure")).to_contain_text("The camera was unplugged")
    assert re.fullmatch(
        r"(1 view is|\d views are) saved. Try again with the same camera to continue.",
        page.locator("#kept").text_content() or "",
    )
    picture(page, "capture-kept", ["hand"])
    before = views(page)
    page.locator("#again").click()
    page.locator("#controls:not([hidden])").wait_for()
    assert views(page) >= before
    wait_for_views(page, before + 1)
    assert len(begun) == 1
    expect_to_continue_without_the_service(page)
    assert len(begun) == 1
    expect_to_end_without_the_service(page)


def expect_to_continue_without_the_service(page: Page) -> None:
    taken = views(page)
    page.route("**/v1/**", lambda route: route.abort())
    page.reload()
    hear(page, "opening-text", "connection to calibDB is lost. Trying again")
    # It is not waited for: the page has targets of its own.
    expect(page.locator("#away")).to_contain_text("No connection. Continue")
    target = page.locator("#target[points*=',']")
    assert len((target.get_attribute("points") or "").split()) == 4
    page.locator("#counts", has_text=re.compile("[2-9] of [3-8] saved here")).wait_for()
    page.evaluate(HIDE, True)  # no view comes between two presses
    picture(page, "capture-away", ["hand"])

    def is_refused() -> bool:
        page.locator("#undo:enabled").click()
        return any("only once calibDB is back" in said for said in heard(page, "notice"))

    until(page, is_refused)
    assert views(page) >= taken, "a view that the service has is not taken back without it"
    page.unroute("**/v1/**")
    page.evaluate(HIDE, False)
    page.locator("#away").wait_for(state="hidden")
    # Instructions after the return are of now.
    earlier = len(heard(page, "instruction"))
    said = [page.locator("#instruction").text_content() or ""]
    wait_for_views(page, taken + 1)
    said += heard(page, "instruction")[earlier:]
    assert not [text for text in said if "onnection" in text], said
    expect(page.locator("#counts")).not_to_contain_text("saved here")


def expect_to_end_without_the_service(page: Page) -> None:
    page.route("**/v1/**", lambda route: route.abort())
    page.locator("#away", has_text="No connection").wait_for()
    stop(page)
    assert requests_within(page, 2.5) == []
    expect(page.locator("#interrupted"), "what a person ended is not offered again").to_be_hidden()


@pytest.mark.thorough
def test_offline_capture_ends_and_is_sent_later(
    context: BrowserContext,
) -> None:
    page = context.new_page()
    listen(page)
    page.goto(VIRTUAL)
    page.locator("#done:not([hidden])").wait_for()
    page.route("**/v1/**", lambda route: route.abort())
    page.route("**/config.json", lambda route: route.abort())
    page.goto(VIRTUAL)
    expect(page.locator("#away")).to_contain_text("No connection. Continue: views are saved on this device")
    page.locator("#counts", has_text=re.compile("[2-7] of 8 saved here")).wait_for()

    page.goto("/calibrate/")
    page.locator("#interrupted-text", has_text="are saved on this device").wait_for()
    page.locator("#go-on").click()
    expect(page.locator("#away")).to_contain_text("No connection")
    page.locator("#instruction", has_text="Enough views. Waiting for calibDB").wait_for()
    assert (page.locator("#counts").text_content() or "").endswith("8 of 8 saved here")
    page.locator("#undo").click()
    hear(page, "notice", "The last view was undone")
    page.locator("#instruction", has_text="Enough views").wait_for()
    picture(page, "capture-enough")
    page.unroute("**/v1/**")
    page.locator("#done:not([hidden])").wait_for()


@pytest.mark.thorough
@pytest.mark.parametrize("lens", ["chosen", "detected"])
def test_suggested_model_starts_with_the_views_so_far(context: BrowserContext, lens: str) -> None:
    page = context.new_page()
    begun = sessions(page)

    def suggest(route: Route) -> None:
        answer = route.fetch()
        route.fulfill(response=answer, json=answer.json() | {"suggested_model": "rational"})

    page.route("**/v1/session/views", suggest)
    if lens == "chosen":
        page.goto(f"{ENDLESS}&distortion_model=rectilinear")
        wait_for_views(page, 2)
        page.locator("#model", has_text="Start again with lens model “Wide-angle (up to 120°)”").click()
    else:
        page.goto(ENDLESS)
    until(page, lambda: len(begun) == 2)
    page.locator("#controls:not([hidden])").wait_for()
    until(page, lambda: views(page) >= 1)
    expect(page.locator("#lens")).to_have_value("rational")
    expect(page.locator("#model")).to_be_hidden()
    models = [request.post_data_json["distortion_model"] for request in begun]
    assert models == ["rectilinear", "rational"]
    assert "distortion_model=rational" in address(page)


@pytest.mark.thorough
def test_a_full_storage_is_said_and_ends_nothing(page: Page) -> None:
    page.add_init_script(FULL)
    page.goto(ENDLESS)
    page.locator("#away", has_text="This browser cannot save views").wait_for()
    wait_for_views(page, views(page) + 1)


BUSY_S = 2.0
# Of a tab that is busy while a request is answered, or not at all.
ACQUIRE = """async (isBusy) => {
  const held = window.held = new AbortController();
  const { acquireLock } = await import("/lib/capture/capture-store.js");
  const isAcquired = acquireLock("a capture", held.signal);
  const request = new XMLHttpRequest();
  request.open("GET", "/slow", false);
  if (isBusy) request.send();
  return isAcquired;
}"""

WITHDRAW = f"""async () => {{
  const late = ({ACQUIRE})(false);
  while (!(await navigator.locks.query()).pending.length) await new Promise((done) => setTimeout(done));
  window.held.abort();
  return [late];
}}"""


def answer_late(route: Route) -> None:
    time.sleep(BUSY_S)
    route.fulfill(body="")


def test_a_capture_belongs_to_one_tab(
    context: BrowserContext,
) -> None:
    first, second = context.new_page(), context.new_page()
    for page in (first, second):
        page.goto(PLAIN)
    first.route("**/slow", answer_late)
    assert first.evaluate(ACQUIRE, True) is True
    assert second.evaluate(ACQUIRE, False) is False
    # Who is gone before it is his turn does not keep the others out.
    late = second.evaluate_handle(WITHDRAW)
    first.evaluate("window.held.abort()")
    late.evaluate("async ([isAcquired]) => await isAcquired")
    assert first.evaluate(ACQUIRE, False) is True


@pytest.mark.thorough
def test_a_second_tab_leaves_the_first_one_alone(context: BrowserContext) -> None:
    first, second = context.new_page(), context.new_page()
    first.bring_to_front()
    first.goto(ENDLESS)
    first.locator("#undo:enabled").wait_for()
    begun = sessions(second)
    second.goto("/calibrate/")
    expect(second.locator("#interrupted"), "it is not interrupted, it goes on").to_be_hidden()
    second.goto(ENDLESS)
    second.locator("#failure", has_text="being calibrated in another tab").wait_for()
    assert begun == []
    first.bring_to_front()
    wait_for_views(first, views(first) + 1)
    first.close()
    second.bring_to_front()
    second.locator("#again").click()
    second.locator("#controls:not([hidden])").wait_for()
    assert views(second) >= 1
