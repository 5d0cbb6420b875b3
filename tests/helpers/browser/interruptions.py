"""Scripts that interrupt a capture, and readers of its progress."""

import re

from playwright.sync_api import Page, Request, expect

from .truth import SMALL

VIRTUAL = f"/calibrate/?{SMALL.query(seed=1)}"
#: the same, before a visitor starts the virtual camera
PRACTICE = VIRTUAL.replace("virtual=1&", "")
#: not reached in the time that a test takes
ENDLESS = f"{VIRTUAL}&target_error=0.01"
UNPLUG = "document.getElementById('video').srcObject.getVideoTracks()[0].dispatchEvent(new Event('ended'))"
HIDE = """(hidden) => {
  Object.defineProperty(document, "hidden", { configurable: true, get: () => hidden });
  document.dispatchEvent(new Event("visibilitychange"));
}"""


def sessions(page: Page) -> list[Request]:
    """Requests of a page that begin sessions; the list grows."""
    begun: list[Request] = []

    def add(request: Request) -> None:
        if request.method == "POST" and request.url.endswith("/v1/session"):
            begun.append(request)

    page.on("request", add)
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
