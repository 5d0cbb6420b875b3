"""Scripts that interrupt a capture, and readers of its progress."""

import json
import re
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Page, Request, expect

from .truth import SMALL

VIRTUAL = f"/calibrate/?{SMALL.query(seed=1)}"
#: the same, before a visitor starts the virtual camera
PRACTICE = VIRTUAL.replace("virtual=1&", "")
#: not reached in the time that a test takes
ENDLESS = f"{VIRTUAL}&target_error=0.01"
#: in the picture; on a busy machine as the plain outline for slow devices
SHOWN_TARGET = "#stage:not(.plain) #overlay:not([hidden]), #stage.plain #target[points*=',']"
TURN = """() => {
  const canvas = document.querySelector(".virtual-camera");
  [canvas.width, canvas.height] = [canvas.height, canvas.width];
}"""
UNPLUG = "document.getElementById('video').srcObject.getVideoTracks()[0].dispatchEvent(new Event('ended'))"
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
# A page that waits longer for answers.
PATIENT = """
  {
    const wait = window.setTimeout;
    window.setTimeout = (call, ms, ...more) => wait(call, [2_000, 5_000].includes(ms) ? 60_000 : ms, ...more);
  }
"""
# As soon as it has a view: the service may end the capture with the next ones.
UNPLUG_WITH_A_VIEW = f"""() => new Promise((done) => {{
  const button = document.getElementById("undo");
  const isReady = () => !button.disabled && button.checkVisibility();
  const look = () => isReady() ? done({UNPLUG}) : requestAnimationFrame(look);
  look();
}})"""
HIDE = """(hidden) => {
  Object.defineProperty(document, "hidden", { configurable: true, get: () => hidden });
  document.dispatchEvent(new Event("visibilitychange"));
}"""
# Hidden at once when a target is in the picture: a quick hand is soon there.
HIDE_WITH_TARGET = f"""() => new Promise((done) => {{
  const stage = document.getElementById("stage");
  const observer = new MutationObserver(() => look());
  const look = () => {{
    if (![...document.querySelectorAll("{SHOWN_TARGET}")].some((each) => each.checkVisibility())) return;
    observer.disconnect();
    ({HIDE})(true);
    done();
  }};
  observer.observe(stage, {{ subtree: true, attributes: true }});
  look();
}})"""


def _posted(page: Page, path: str, add: Callable[[Request], None]) -> None:
    page.on(
        "request",
        lambda request: add(request) if request.method == "POST" and request.url.endswith(path) else None,
    )


def sessions(page: Page) -> list[Request]:
    """Requests of a page that begin sessions; the list grows."""
    begun: list[Request] = []
    _posted(page, "/v1/session", begun.append)
    return begun


def views(page: Page) -> int:
    return int(page.locator("#counts").get_attribute("data-taken") or "0")


def wait_for_views(page: Page, count: int) -> None:
    """Wait until at least so many views are taken, up to 99."""
    numbers = "|".join(str(number) for number in range(count, 100))
    expect(page.locator("#counts")).to_have_attribute("data-taken", re.compile(rf"^({numbers})$"))


def stop(page: Page) -> None:
    """End a capture that has views: the button is pressed twice within five seconds."""
    expect(page.locator("#stop")).to_be_enabled()
    page.locator("#stop").evaluate("(button) => { button.click(); button.click(); }")
    page.locator("#welcome:not([hidden])").wait_for()


def done(page: Page) -> None:
    """Wait for a capture's result with its report."""
    page.locator("#done:not([hidden])").wait_for()
    page.locator("#done .views li").first.wait_for(state="attached")


def sent_views(page: Page) -> list[Any]:
    """Corner positions of the views that a page sends; the list grows."""
    sent: list[Any] = []
    _posted(page, "/session/views", lambda view: sent.append(json.loads(view.post_data or "")["points"]))
    return sent
