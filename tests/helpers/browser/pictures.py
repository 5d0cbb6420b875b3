"""Pictures of pages at a desk, on a tablet and in a hand, and their faults."""

import time
from collections.abc import Callable, Iterable
from typing import TypeVar

import cv2
import numpy as np
import numpy.typing as npt
from playwright.sync_api import Locator, Page, ViewportSize

from ...browser.conftest import OUTPUT, ROOT
from ...conftest import THOROUGH
from .waiting import TIMEOUT_S

AXE = ROOT / "node_modules" / "axe-core" / "axe.min.js"
SIZES: dict[str, ViewportSize] = {
    "desk": {"width": 1440, "height": 900},
    "tablet": {"width": 820, "height": 1180},
    "hand": {"width": 390, "height": 844},
}
FINGER = 44  # px, WCAG 2.5.5
INLINE = 24  # px, WCAG 2.5.8: within a line of text
WIDE = """() => {
  const { scrollWidth, clientWidth } = document.documentElement;
  return Math.max(0, scrollWidth - clientWidth);
}"""
# Drawn again after a change of the window's size, and all finite animations have ended.
SETTLED = """async () => {
  for (let frame = 0; frame < 3; frame++) await new Promise((done) => requestAnimationFrame(done));
  const passing = document.getAnimations().filter((each) => each.effect?.getTiming().iterations !== Infinity);
  await Promise.allSettled(passing.map(({ finished }) => finished));
}"""
T = TypeVar("T")

# Targets that are smaller than a finger. A label counts for its box.
SMALL = """([finger, inline]) => {
  const touched = document.querySelectorAll("a[href], button, select, input, summary");
  return [...touched].flatMap((element) => {
    const target = element.closest("label") ?? (element.type === "radio" ? element.labels[0] : element);
    const { width, height } = target.getBoundingClientRect();
    if (width === 0 || !element.checkVisibility({ visibilityProperty: true })) return [];
    const least = getComputedStyle(target).display === "inline" ? inline : finger;
    return height + 0.5 < least || width + 0.5 < inline
      ? [`${element.outerHTML.slice(0, 120)}: ${width.toFixed(0)} x ${height.toFixed(0)}`] : [];
  });
}"""


def remaining(page: Page, faults: Callable[[], T]) -> T:
    """Faults of a page that remain after its changes have ended, or after TIMEOUT_S."""
    end = time.monotonic() + TIMEOUT_S
    while (found := faults()) and time.monotonic() < end:
        page.evaluate(SETTLED)
    return found


def shot(place: Page | Locator, flag: int = cv2.IMREAD_COLOR) -> npt.NDArray[np.uint8]:
    """Screenshot of a page or of an element, as OpenCV reads it."""
    return np.asarray(cv2.imdecode(np.frombuffer(place.screenshot(), np.uint8), flag), dtype=np.uint8)


def violations(page: Page, *rules: str) -> list[str]:
    """List what axe finds, by these rules or by all."""
    # The content security policy of the pages refuses an added script.
    if not page.evaluate("'axe' in window"):
        page.evaluate(f"() => {{ {AXE.read_text()} }}")
    # Style sheets would be fetched once more for a rule that is off by default.
    options = {"resultTypes": ["violations"], "preload": {"assets": ["media"]}, "selectors": False}
    found = page.evaluate(
        "async (options) => (await axe.run(options)).violations",
        options | ({"runOnly": list(rules)} if rules else {}),
    )
    return [f"{v['id']}: {v['help']}: {[n['html'] for n in v['nodes']]}" for v in found]


def picture(
    page: Page, name: str, sizes: Iterable[str] = ("desk", "hand"), *, full: bool = False, check: bool = True
) -> None:
    """Assert that a page does not scroll sideways, passes axe, and has targets for fingers.

    In the last size only; `make thorough` does it in all sizes, and saves pictures.
    """
    OUTPUT.mkdir(exist_ok=True)
    for size in list(sizes) if THOROUGH else list(sizes)[-1:]:
        page.set_viewport_size(SIZES[size])
        page.evaluate(SETTLED)
        if THOROUGH:
            page.screenshot(path=OUTPUT / f"{name}-{size}.png", full_page=full)
        if check:
            assert remaining(page, lambda: page.evaluate(WIDE)) == 0, f"{name} is too wide, px"
            assert remaining(page, lambda: violations(page)) == []
            assert remaining(page, lambda: page.evaluate(SMALL, [FINGER, INLINE])) == []
