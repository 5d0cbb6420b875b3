"""What can happen in the middle of a capture, and how far it has come."""

import json
from typing import Any

from playwright.sync_api import Page, Request

from .truth import Truth

VIRTUAL = f"/calibrate/?{Truth().query(seed=3)}"
#: not reached in the time that a test takes
ENDLESS = f"{VIRTUAL}&target_error=0.05"
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
# A camera that can hold its focus, and says where once it does.
FOCUS = """
  MediaStreamTrack.prototype.getCapabilities = () => ({ focusMode: ["continuous", "manual"] });
  MediaStreamTrack.prototype.applyConstraints = async function ({ advanced: [{ focusMode }] }) {
    if (focusMode === "manual") Object.assign(this.getSettings(), { focusMode, focusDistance: 0.4 });
  };
"""
HIDE = """(hidden) => {
  Object.defineProperty(document, "hidden", { configurable: true, get: () => hidden });
  document.dispatchEvent(new Event("visibilitychange"));
}"""

# The views on this device.
KEPT = """() => new Promise((done) => {
  const opening = indexedDB.open("calibdb", 1);
  opening.onsuccess = () => {
    const asking = opening.result.transaction("captures").objectStore("captures").getAll();
    asking.onsuccess = () => done(asking.result.flatMap(({ views }) => views));
  };
})"""
# Requests say when they were made. Written down is what is to be seen: instruction, a full ring, what stands.
WRITTEN = """
  Object.assign(window, { seen: [] });
  const send = window.fetch;
  window.fetch = (address, request) => {
    const headers = new Headers(request?.headers);
    headers.set("x-asked", performance.now());
    return send(address, { ...request, headers });
  };
  document.addEventListener("DOMContentLoaded", () => {
    const [instruction, ring, held, away] =
      ["instruction", "ring", "held", "away"].map((id) => document.getElementById(id));
    const isFull = () => ring.classList.contains("taken")
      || held.getAttribute("stroke-dasharray") === "100 100";
    new MutationObserver(() => window.seen.push([
      performance.now(), instruction.textContent, !ring.hasAttribute("hidden") && isFull(),
      away.hidden ? "" : away.textContent,
    ])).observe(document.getElementById("stage").parentElement,
      { subtree: true, childList: true, characterData: true, attributes: true });
  });
"""


def sessions(page: Page) -> list[Request]:
    """Sessions begun by a page, as they are begun."""
    begun: list[Request] = []
    page.on(
        "request",
        lambda request: (
            begun.append(request)
            if request.method == "POST" and request.url.endswith("/v1/session")
            else None
        ),
    )
    return begun


def views(page: Page) -> int:
    return int((page.locator("#counts").text_content() or "0").split()[0])


def wait_for_views(page: Page, count: int, seconds: float = 60.0) -> None:
    # The policy of the pages refuses a function that is made of a string, such as a test could wait for.
    for _ in range(int(10 * seconds)):
        if views(page) >= count:
            return
        page.wait_for_timeout(100)
    raise AssertionError(f"{views(page)} views in {seconds:.0f} s, not {count}")


def sent_views(page: Page) -> list[Any]:
    """Corner positions of the views that a page sends, as they are sent."""
    sent: list[Any] = []
    page.on(
        "request",
        lambda request: (
            sent.append(json.loads(request.post_data or "")["points"])
            if request.method == "POST" and request.url.endswith("/session/views")
            else None
        ),
    )
    return sent
