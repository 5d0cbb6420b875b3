"""Captures in several tabs."""

import time

import pytest
from playwright.sync_api import BrowserContext, Route, expect

from tests.helpers.browser.interruptions import ENDLESS, sessions, views, wait_for_views
from tests.helpers.browser.scripts import PLAIN

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
