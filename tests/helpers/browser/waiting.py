"""Waiting for what a page does, and for what it did a moment ago."""

import re
import time
from collections.abc import Callable
from typing import TypeVar

from playwright.sync_api import Page

#: seconds; only what fails is waited for so long: a machine may be slow, or busy with something else
PATIENCE = 120.0

# What a page says in some places, written down: what stands for a moment may be over before one asks.
_LISTEN = """
  window.said = {};
  document.addEventListener("DOMContentLoaded", () => {
    for (const id of ["another", "away", "instruction", "notice", "opening", "opening-text", "said"]) {
      const place = document.getElementById(id);
      const said = window.said[id] = [];
      const write = () => place.closest("[hidden]") || said.push(place.textContent);
      const changes = { subtree: true, childList: true, characterData: true, attributeFilter: ["hidden"] };
      if (place) new MutationObserver(write).observe(place, changes);
    }
  });
"""

T = TypeVar("T")


def until(page: Page, holds: Callable[[], T], seconds: float = PATIENCE) -> T:
    """Wait until something holds, and return it; what the page does meanwhile is heard of."""
    end = time.monotonic() + seconds
    while not (found := holds()):
        assert time.monotonic() < end, f"it did not happen in {seconds:.0f} s"
        page.wait_for_timeout(50)
    return found


def address(page: Page) -> str:
    """Return where a page is by itself: the browser tells of it a little later."""
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
    """Wait until a page has said what fits a pattern."""
    until(page, lambda: any(re.search(words, text) for text in heard(page, where)))
