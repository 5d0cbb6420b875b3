"""Waiting for conditions that `expect` cannot see: requests, storage, and short-lived texts."""

import json
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

from playwright.sync_api import Page, Request
from playwright.sync_api import TimeoutError as PlaywrightTimeoutError

#: s
TIMEOUT_S = 120.0

# Record texts in some places, also those that are shown only for a moment, with the frames looked at before.
_LISTEN = """
  window.said = {};
  document.addEventListener("DOMContentLoaded", () => {
    const places = ["another", "away", "instruction", "notice", "opening", "opening-text", "said", "stop"];
    for (const id of places) {
      const place = document.getElementById(id);
      const said = window.said[id] = [];
      const write = () => place.closest("[hidden]") || said.push([place.textContent, window.looks]);
      const changes = { subtree: true, childList: true, characterData: true, attributeFilter: ["hidden"] };
      if (place) new MutationObserver(write).observe(place, changes);
    }
  });
"""

# Record whether a text was in one of the places, even for a moment.
_PASSING = """([places, text]) => {
  window.passed = false;
  new MutationObserver((_, observer) => {
    if (![...document.querySelectorAll(places)].some((place) => place.textContent.includes(text))) return;
    window.passed = true;
    observer.disconnect();
  }).observe(document.body, { subtree: true, childList: true, characterData: true });
}"""

_DRAWN = """() => new Promise((done) =>
  requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done))))"""

T = TypeVar("T")


def until(page: Page, holds: Callable[[], T]) -> T:
    """Wait until a condition holds that no locator can express, and return its value.

    The condition is evaluated after each request, or after 50 ms.
    """
    end = time.monotonic() + TIMEOUT_S
    while not (found := holds()):
        assert time.monotonic() < end, f"it did not happen in {TIMEOUT_S:.0f} s"
        with suppress(PlaywrightTimeoutError):
            page.wait_for_event("request", timeout=50)
    return found


def requests_within(page: Page, seconds: float) -> list[str]:
    """Address of the first request that a page makes in so many seconds, or []."""
    try:
        return [page.wait_for_event("request", timeout=1000 * seconds).url]
    except PlaywrightTimeoutError:
        return []


@contextmanager
def at_rest(page: Page) -> Iterator[None]:
    """Wait until the requests of the block have ended and the page is drawn, or for 15 s.

    `networkidle` takes half a second more for each page, and never comes if a worker's import fails.
    """
    pending: set[Request] = set()

    def begin(request: Request) -> None:
        pending.add(request)

    def end(request: Request) -> None:
        pending.discard(request)

    listeners = {"request": begin, "requestfinished": end, "requestfailed": end}
    for event, listener in listeners.items():
        page.on(event, listener)  # type: ignore[call-overload]
    yield
    limit, quiet = time.monotonic() + 15, 0
    while quiet < 3 and time.monotonic() < limit:
        page.evaluate(_DRAWN)
        quiet = 0 if pending else quiet + 1
    for event, listener in listeners.items():
        page.remove_listener(event, listener)


def uncaught(page: Page) -> list[str]:
    """Errors that a page does not catch, as they come."""
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    return errors


def shown_calibration(page: Page) -> dict[str, Any]:
    """The calibration that a result shows as JSON."""
    found: dict[str, Any] = json.loads(page.locator("#json").text_content() or "")
    return found


def address(page: Page) -> str:
    """Address of a page, which Playwright learns a little later."""
    there: str = page.evaluate("location.href")
    return there


def listen(page: Page) -> None:
    """Record the texts of a page from its next navigation on, for `heard`."""
    page.add_init_script(_LISTEN)


def heard(page: Page, where: str) -> list[str]:
    """All texts in one place since the page was opened."""
    # None yet before it is there
    texts: list[str] = page.evaluate("(id) => (window.said[id] ?? []).map(([text]) => text)", where)
    return texts


def hear(page: Page, where: str, words: str) -> None:
    """Wait until a page has shown a text that matches a pattern, even for a moment."""
    until(page, lambda: any(re.search(words, text) for text in heard(page, where)))


@contextmanager
def passing(page: Page, places: str, text: str) -> Iterator[None]:
    """Wait until a text has been in one of the places during or after the block, even for a moment."""
    page.evaluate(_PASSING, [places, text])
    yield
    until(page, lambda: page.evaluate("window.passed"))
