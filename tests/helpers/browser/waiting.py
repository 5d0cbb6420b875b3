"""Waiting for conditions that `expect` cannot see: requests, storage, and texts that pass."""

import json
import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

from playwright.sync_api import Page, Request
from playwright.sync_api import TimeoutError as PlaywrightTimeoutError

#: seconds; only what fails is waited for so long: a machine may be slow, or busy with something else
TIMEOUT_S = 120.0

# What a page says in some places, written down: what stands for a moment may be over before one asks.
_LISTEN = """
  window.said = {};
  document.addEventListener("DOMContentLoaded", () => {
    const places = ["another", "away", "instruction", "notice", "opening", "opening-text", "said", "stop"];
    for (const id of places) {
      const place = document.getElementById(id);
      const said = window.said[id] = [];
      const write = () => place.closest("[hidden]") || said.push(place.textContent);
      const changes = { subtree: true, childList: true, characterData: true, attributeFilter: ["hidden"] };
      if (place) new MutationObserver(write).observe(place, changes);
    }
  });
"""

# Whether a text was in one of the places, be it for a moment only.
_PASSING = """([places, text]) => {
  window.passed = false;
  new MutationObserver((_, observer) => {
    if (![...document.querySelectorAll(places)].some((place) => place.textContent.includes(text))) return;
    window.passed = true;
    observer.disconnect();
  }).observe(document.body, { subtree: true, childList: true, characterData: true });
}"""

# Two frames, and what they brought about.
_DRAWN = """() => new Promise((done) =>
  requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done))))"""

T = TypeVar("T")


def until(page: Page, holds: Callable[[], T], seconds: float = TIMEOUT_S) -> T:
    """Wait until a condition holds that no locator can express, and return its value.

    What is visible in a page is waited for by `expect`. This is for requests that arrived, for storage and
    for variables of the page; the condition is looked at after each request, or after 50 ms.
    """
    end = time.monotonic() + seconds
    while not (found := holds()):
        assert time.monotonic() < end, f"it did not happen in {seconds:.0f} s"
        with suppress(PlaywrightTimeoutError):
            page.wait_for_event("request", timeout=50)
    return found


def requests_within(page: Page, seconds: float) -> list[str]:
    """Address of the first request that a page makes in so many seconds; [] where it makes none."""
    try:
        return [page.wait_for_event("request", timeout=1000 * seconds).url]
    except PlaywrightTimeoutError:
        return []


@contextmanager
def at_rest(page: Page, seconds: float = 15.0) -> Iterator[None]:
    """Wait until all that a page asks for in the block has arrived and is drawn, or for so many seconds.

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
    limit, quiet = time.monotonic() + seconds, 0
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
    """Address of a page by its own account: Playwright learns of it a little later."""
    there: str = page.evaluate("location.href")
    return there


def listen(page: Page) -> None:
    """Write down what the page says from its next address on."""
    page.add_init_script(_LISTEN)


def heard(page: Page, where: str) -> list[str]:
    """All that a page has said in one place since it was opened."""
    texts: list[str] = page.evaluate("(id) => window.said[id] ?? []", where)  # none yet before it is there
    return texts


def hear(page: Page, where: str, words: str) -> None:
    """Wait until a page has shown a text that fits a pattern, be it for a moment only.

    `expect(locator)` looks from time to time and misses a notice that stands for a second on a busy machine;
    the observer of `listen` writes every text down. Texts that stay are waited for by `expect`.
    """
    until(page, lambda: any(re.search(words, text) for text in heard(page, where)))


@contextmanager
def passing(page: Page, places: str, text: str) -> Iterator[None]:
    """Wait until what is done in the block has shown a text in one of the places, be it for a moment only."""
    page.evaluate(_PASSING, [places, text])
    yield
    until(page, lambda: page.evaluate("window.passed"))
