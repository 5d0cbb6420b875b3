"""Faults that last, at their full length: nothing captured is lost, and the page says what happens."""

import pytest
from playwright.sync_api import BrowserContext

from .interruptions import ENDLESS, sent_views, views, wait_for_views

KEPT = """() => new Promise((done) => {
  const opening = indexedDB.open("calibdb", 1);
  opening.onsuccess = () => {
    const asking = opening.result.transaction("captures").objectStore("captures").getAll();
    asking.onsuccess = () => done(asking.result.flatMap(({ views }) => views));
  };
})"""


@pytest.mark.thorough
def test_twenty_seconds_without_the_service(context: BrowserContext) -> None:
    page = context.new_page()  # refused requests are errors in the console
    sent = sent_views(page)
    page.goto(ENDLESS)
    page.locator("#undo:enabled").wait_for()
    there = views(page)
    page.route("**/v1/**", lambda route: route.abort())
    page.locator("#away", has_text="Without connection: go on").wait_for()
    page.wait_for_timeout(20_000)
    kept = page.evaluate(KEPT)
    assert len(kept) >= there + 3, "the capture goes on meanwhile"
    before = len(sent)
    page.unroute("**/v1/**")
    page.locator("#away").wait_for(state="hidden", timeout=20_000)
    page.locator("#notice", has_text="calibDB is back").wait_for()
    waiting = [view["points"] for view in kept if not view["taken"]]
    assert len(waiting) >= 3
    assert [view in sent[before:] for view in waiting] == [True] * len(waiting), "what was kept is sent"
    wait_for_views(page, there + 1)
