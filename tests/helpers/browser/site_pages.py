"""Every page of the site, and its visible faults."""

from playwright.sync_api import CDPSession, Page, ViewportSize

from ...conftest import THOROUGH
from .pictures import SETTLED, remaining
from .scenes import BLIND_DETECTOR
from .scripts import page_function
from .specimens import answer, camera, cameras, dump, result, rig, statistics
from .waiting import at_rest

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
    "ar.js": "examples/arjs/",
    "developers": "developers/",
    "data": "data/",
    "privacy": "privacy/",
    "terms": "terms/",
    "status": "status/",
    "docs": "docs/",
    "quickstart": "docs/quickstart/",
    "call": "docs/reference/lookup/",
    "calls": "docs/reference/",
    "reference": "docs/api/",
    "accuracy": "docs/accuracy/",
    "problems": "docs/problems/",
    "missing": "nothing-here/",
}
#: pages whose content comes from the service or the visitor's device, or is long
FILLED_IN = ("landing", "sent", "cameras", "result", "data", "status", "reference")
#: pages of no other test
ONLY_HERE = ("rig-result", "docs", "call", "reference", "missing")
VISITED = PAGES if THOROUGH else dict.fromkeys((*FILLED_IN, *ONLY_HERE))
SIZES: dict[int, ViewportSize] = {
    width: {"width": width, "height": height}
    for width, height in ((320, 640), (390, 844), (768, 1024), (1440, 900), (2560, 1440))
}
#: a tenth of the shift that people notice, after web.dev
MAX_SHIFT = 0.01

_ANSWERS = {
    "**/v1/cameras?*": cameras,
    "**/v1/cameras/*": camera,
    "**/v1/calibrations/x": result,
    "**/v1/rigs/*": rig,
    "**/dumps/statistics.json": statistics,
    "**/dumps/latest.json": dump,
}
# Responses come after the first paint, as those of a real service: they move what is seen.
_LATE = """
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
WATCH_SHIFTS = """
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
# Visible, enabled buttons without a listener after the modules have run. A form with an address needs none.
_UNHEARD = """
  const [heard, add] = [new Set(), HTMLElement.prototype.addEventListener];
  HTMLElement.prototype.addEventListener = function (type, ...rest) {
    if (["click", "submit", "reset"].includes(type)) heard.add(this);
    return add.call(this, type, ...rest);
  };
  document.addEventListener("DOMContentLoaded", () => {
    const buttons = [...document.querySelectorAll("button:enabled")].filter((each) => each.checkVisibility());
    const idle = buttons.filter((each) => !each.form?.hasAttribute("action"));
    const unheard = idle.filter((each) => !heard.has(each) && !heard.has(each.form));
    window.unheard = unheard.map((each) => each.outerHTML);
  });
"""
_AMISS = page_function("page_faults")


def prepare(page: Page) -> CDPSession:
    """Answer a page's requests by specimens, and watch what moves; return a session for `visit`."""
    for pattern, body in _ANSWERS.items():
        answer(page, pattern, body)
    page.add_init_script(f"{{ {_LATE} }} {BLIND_DETECTOR} {WATCH_SHIFTS} {_UNHEARD}")
    return page.context.new_cdp_session(page)


def visit(page: Page, session: CDPSession, name: str, language: str) -> None:
    """Open a page in a language, as at a first visit, and wait until all its requests have ended.

    In `make test` pages whose shifts are not tested may use the cache.
    """
    is_first = THOROUGH or name in FILLED_IN
    session.send("Network.setCacheDisabled", {"cacheDisabled": is_first})
    with at_rest(page):
        page.goto(f"/{'' if language == 'en' else f'{language}/'}{PAGES[name]}")
        page.evaluate("window.drawn")
    page.evaluate(SETTLED)


def unheard(page: Page) -> list[str]:
    found: list[str] = page.evaluate("window.unheard")
    return [f"does not listen to {button}" for button in found]


def shifts(page: Page) -> list[tuple[float, list[str]]]:
    """Distances and names of the parts of the page that have moved since it was opened."""
    found: list[tuple[float, list[str]]] = page.evaluate("window.shifts")
    return found


def faults(page: Page, width: int) -> list[str]:
    page.set_viewport_size(SIZES[width])
    page.evaluate(SETTLED)
    return remaining(page, lambda: page.evaluate(_AMISS))
