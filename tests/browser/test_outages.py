"""Outages of the service during a capture."""

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import BrowserContext, Route

from tests.helpers.browser.interruptions import (
    ENDLESS,
    ENDURING,
    STORED_VIEWS,
    WRITTEN,
    sent_views,
    views,
    wait_for_views,
)
from tests.helpers.browser.waiting import until

# A function that has not run for a while has to start: its first answers take longer.
# `slowest`: the longest that the page waited, ms.
COLD = """
  const cold = ["pose", "views"];
  const answer = window.fetch;
  window.slowest = 0;
  window.fetch = async (address, request) => {
    const [, kind] = /\\/v1\\/session\\/([a-z]+)/.exec(address) ?? [];
    const asked = performance.now();
    if (cold.includes(kind)) {
      cold.splice(cold.indexOf(kind), 1);
      await new Promise((resolve) => setTimeout(resolve, 3_000));
    }
    try {
      return await answer(address, request);
    } finally {
      window.slowest = Math.max(window.slowest, performance.now() - asked);
    }
  };
"""


@pytest.mark.thorough
@pytest.mark.parametrize("outage", ["silent", "refused", "busy", "asks to wait"])
def test_two_seconds_timeout_for_every_outage(context: BrowserContext, outage: str) -> None:
    page = context.new_page()
    page.add_init_script(WRITTEN + (ENDURING + COLD if outage == "silent" else ""))
    sent = sent_views(page)
    held: list[Route] = []
    back: list[str] = []
    answers: dict[str, Callable[[Route], None]] = {
        "silent": lambda route: route.continue_() if back else held.append(route),
        "refused": lambda route: route.abort(),
        "busy": lambda route: route.fulfill(status=503),
        "asks to wait": lambda route: route.fulfill(status=503, headers={"retry-after": "5"}),
    }
    page.goto(ENDLESS)
    page.locator("#undo:enabled").wait_for()
    if outage == "silent":  # a service that has to start is not taken for one that is away
        first = page.evaluate("window.seen")
        if any(away for _, _, _, away in first):  # a busy machine answers late, which is an outage, too
            until(page, lambda: page.evaluate("window.slowest") > 2_000)
            page.locator("#away").wait_for(state="hidden")
        else:
            waited = [time for time, text, _, _ in first if text == "One moment"]
            # Longer than for a service that has started; the words come a moment after the request.
            assert max(waited) - min(waited) > 2_000
    met: list[float] = []  # ms, when each request was made that the outage met

    def answer(route: Route) -> None:
        if not met and route.request.method != "POST":
            return route.continue_()
        met.append(float(route.request.headers["x-asked"]))
        return answers[outage](route)

    page.route("**/v1/session**", answer)
    there = views(page)
    asked = min(until(page, lambda: met))
    page.locator("#away", has_text="No connection. Continue: views are saved on this device.").wait_for()
    stood = until(page, lambda: [said for time, said in page.evaluate("window.stood") if time == asked])
    assert stood == [True], "said within three seconds"
    seen = [each for each in page.evaluate("window.seen") if each[0] > asked]
    said = next(time for time, _, _, away in seen if away)
    waiting = [each for each in seen if asked + 100 < each[0] < said]
    assert not [each for each in waiting if each[2]], "no full ring while nothing comes back"
    assert {"One moment", "Connection lost. Trying again"} & {text for _, text, _, _ in waiting}

    page.locator("#counts", has_text=re.compile("[2-9] of [3-8] saved here")).wait_for()
    kept = page.evaluate(STORED_VIEWS)
    back.append(outage)
    for route in held:
        route.continue_()
    page.unroute("**/v1/session**")
    page.locator("#away").wait_for(state="hidden")
    wait_for_views(page, there + 1)
    assert [view["points"] in sent for view in kept] == [True] * len(kept)
    if outage == "silent":
        assert [sent.count(view) for view in sent] == [1] * len(sent), "a late answer is one"
