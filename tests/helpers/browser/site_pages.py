"""Every page of the site as most people see it, and what may be wrong with how it looks."""

from __future__ import annotations

import time

from playwright.sync_api import Page, ViewportSize

from ...conftest import THOROUGH
from .pictures import SETTLED
from .scripts import page_function
from .specimens import answer, camera, cameras, dump, result, rig, statistics
from .waiting import TIMEOUT_S, at_rest

PAGES = {
    "landing": "",
    "calibrate": "calibrate/",
    "sent": "calibrate/?camera=HD+Pro+Webcam+C920+(046d:082d)&img_size=1280x720"
    "&return_to=https://app.example/",
    "rig": "rig/",
    "rig-join": "rig/?code=ABC234",
    "rig-result": "rig/?id=12218ed74dc03e8563d2918b05d67fdb",
    "photos": "photos/",
    "import": "import/",
    "cameras": "cameras/",
    "camera": "cameras/?key=c2.specimen",
    "mine": "mine/",
    "result": "result/?id=x",
    "board": "board/",
    "ar": "ar/",
    "examples": "examples/",
    "example": "examples/three/",
    "developers": "developers/",
    "data": "data/",
    "privacy": "privacy/",
    "terms": "terms/",
    "status": "status/",
    "docs": "docs/",
    "quickstart": "docs/quickstart/",
    "call": "docs/reference/lookup/",
    "reference": "docs/api/",
    "problems": "docs/problems/",
    "missing": "nothing-here/",
} | ({"calls": "docs/reference/", "accuracy": "docs/accuracy/"} if THOROUGH else {})
#: their content comes from the service, from the visitor's device, or is long
FILLED_IN = ("landing", "sent", "cameras", "result", "data", "status", "reference")
SIZES: dict[int, ViewportSize] = {
    width: {"width": width, "height": height}
    for width, height in ((320, 640), (390, 844), (768, 1024), (1440, 900), (2560, 1440))
}
#: a tenth of the shift that people notice, after web.dev
MAX_SHIFT = 0.01

# Nothing is answered before the page was drawn once: what comes of an answer moves what is seen.
_LATE_ANSWERS = """
  const drawn = window.drawn = new Promise((done) => {
    new PerformanceObserver((list, observer) => {
      observer.disconnect();
      requestAnimationFrame(() => requestAnimationFrame(done));
    }).observe({ type: "paint", buffered: true });
  });
  const send = window.fetch;
  window.fetch = async (...request) => {
    await drawn;
    return send(...request);
  };
"""
_WATCH = """
  window.shifts = [];
  const name = (node) =>
    node?.nodeType === 1 ? `${node.nodeName}#${node.id}.${node.className}` : node?.nodeName;
  window.shifting = new PerformanceObserver((list) => {
    for (const { value, hadRecentInput, sources } of list.getEntries()) {
      if (!hadRecentInput) window.shifts.push([value, sources.map(({ node }) => name(node))]);
    }
  });
  window.shifting.observe({ type: "layout-shift", buffered: true });
"""
_AMISS = page_function("page_faults")


def prepare(page: Page) -> None:
    """Let a page be answered by specimens, after it was drawn once, and watch what moves."""
    answer(page, "**/v1/cameras?*", cameras)
    answer(page, "**/v1/cameras/*", camera)
    answer(page, "**/v1/calibrations/x", result)
    answer(page, "**/v1/rigs/*", rig)
    answer(page, "**/dumps/statistics.json", statistics)
    answer(page, "**/dumps/latest.json", dump)
    # 3 MB that show nothing. The worker itself: what a worker imports in vain is pending for ever.
    page.route("**/detector.worker.js", lambda route: route.abort())
    page.add_init_script(_LATE_ANSWERS)
    page.add_init_script(_WATCH)


def visit(page: Page, name: str, language: str) -> None:
    """Open a page in a language, and wait until all that it asks for is there."""
    with at_rest(page):
        page.goto(f"/{'' if language == 'en' else f'{language}/'}{PAGES[name]}")
        page.evaluate("window.drawn")
    page.evaluate(SETTLED)


def shifts(page: Page) -> list[tuple[float, list[str]]]:
    """List how far parts of the page have moved, and which, since it was opened."""
    found: list[tuple[float, list[str]]] = page.evaluate("window.shifts")
    return found


def faults(page: Page, width: int, seconds: float = TIMEOUT_S) -> list[str]:
    """List what is wrong with the page in a window of that width, once it has come to rest."""
    page.set_viewport_size(SIZES[width])
    end = time.monotonic() + seconds
    while True:
        page.evaluate(SETTLED)
        found: list[str] = page.evaluate(_AMISS)
        if not found or time.monotonic() > end:
            return found
