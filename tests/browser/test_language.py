"""Languages of the pages, and the menu in their header."""

import re

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.pictures import picture
from tests.helpers.browser.scenes import no_network, unreadable
from tests.helpers.browser.waiting import at_rest, until
from tests.helpers.marks import thorough

from ..conftest import THOROUGH
from .conftest import Visitor

PATHS = ("/cameras/?query=c920", "/cameras/?key=c2.none", "/result/?id=none")
REFUSED = {"title": "Forbidden", "status": 403, "detail": "The API token is not valid."}
LINE = {"offline": False, "latency": 150, "downloadThroughput": 1.6e6 / 8, "uploadThroughput": 0.75e6 / 8}
# Each text that is in a frame, and the language of each document of which something was painted.
EVERY_FRAME = """
  const told = new Set();
  const look = () => {
    for (const each of document.querySelectorAll("[data-t]")) {
      const text = each.textContent.trim();
      if (told.has(text) || !each.checkVisibility({ visibilityProperty: true })) continue;
      told.add(text);
      window.shown(text);
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
  new PerformanceObserver((list) => {
    for (const { name } of list.getEntries()) {
      if (name === "first-contentful-paint") window.painted(document.documentElement.lang);
    }
  }).observe({ type: "paint", buffered: true });
"""
TEXTS = """async (path) => {
  const page = new DOMParser().parseFromString(await (await fetch(path)).text(), "text/html");
  return [...page.querySelectorAll("[data-t]")].map((each) => each.textContent.trim());
}"""


def speak(page: Page, language: str) -> None:
    page.locator("#language").select_option(language)


def test_messages_follow_the_language(page: Page) -> None:
    page.goto("/?lang=en")
    page.locator("#look").click()
    page.locator("#outcome", has_text="No camera was found").wait_for()
    assert (page.locator("#outcome a").get_attribute("href") or "").endswith("/cameras/")
    speak(page, "de")
    page.locator("#outcome", has_text="keine Kamera").wait_for()

    page.goto("/photos/")
    state = page.locator("#files-state")
    expect(state).to_have_text("Noch nichts gewählt")
    speak(page, "en")
    page.locator("#files").set_input_files([unreadable("IMG_1.HEIC"), unreadable("notes.txt", "text/plain")])
    page.locator("#status", has_text="Browsers cannot read HEIC").wait_for()
    speak(page, "de")
    page.locator("#status", has_text="HEIC nicht lesen. Speichern Sie IMG_1.HEIC als JPEG").wait_for()
    page.locator("#status", has_text="Kein Foto und kein Video: notes.txt").wait_for()
    expect(state).to_have_text("2 Dateien gewählt")
    expect(page.locator("#status")).not_to_contain_text("cannot")


def test_outages_and_refusals_are_reported_in_every_language(
    context: BrowserContext,
) -> None:
    page = context.new_page()
    for path in PATHS if THOROUGH else PATHS[-1:]:
        no_network(page)
        page.goto(f"{path}&lang=en")
        page.locator("[role=status]", has_text="calibDB cannot be reached just now. Trying again.").wait_for()
        # The later route is asked first: at no moment does a repeated request reach the service itself.
        page.route("**/v1/**", lambda route: route.fulfill(status=403, json=REFUSED))
        page.locator("[role=status]", has_text="does not accept this page's token").wait_for()
        speak(page, "de")
        page.locator("[role=status]", has_text="erkennt diese Seite nicht an").wait_for()
        expect(page.locator("main")).not_to_contain_text(REFUSED["detail"])
        page.unroute("**/v1/**")


def test_what_is_not_there_is_said_in_the_language_of_the_page(context: BrowserContext) -> None:
    page = context.new_page()
    for path in PATHS[1:] if THOROUGH else PATHS[1:2]:
        page.goto(f"/de{path}")
        page.locator("#waiting p", has_text="gibt es").wait_for()
        expect(page.locator("#waiting .actions a:visible")).to_have_count(2)
    picture(page, "missing", ["hand"])


@pytest.mark.parametrize(
    ("language", "path"),
    [("de", "/"), *thorough(("uk", "/calibrate/"), ("de", "/result/?id=none"))],
)
def test_no_frame_of_english_is_painted_in_another_language(
    visitor: Visitor, language: str, path: str
) -> None:
    context = visitor(locale=f"{language}-XX")
    shown: list[str] = []
    painted: list[str] = []
    page = context.new_page()
    page.goto("/terms/?lang=en")
    there = path.split("?")[0]
    english, own = (set(page.evaluate(TEXTS, f"{prefix}{there}")) for prefix in ("", f"/{language}"))
    page.evaluate("localStorage.clear()")
    page.expose_function("shown", lambda text: shown.append(text))
    page.expose_function("painted", lambda spoken: painted.append(spoken))
    page.add_init_script(EVERY_FRAME)
    page.route("**/*.wasm", lambda route: route.abort())
    session = context.new_cdp_session(page)
    session.send("Network.enable")
    session.send("Network.emulateNetworkConditions", LINE)
    with at_rest(page):
        page.goto(path)
        page.wait_for_url(f"**/{language}{there}**")
        page.locator("#language[data-in-place]").wait_for()
    until(page, lambda: painted and len(set(shown) & own) > 3)
    assert painted == [language], f"{path}: documents of which something was painted"
    assert len(set(shown) & own) > 3
    foreign = {text for text in shown if text in english - own or re.fullmatch(r"[a-z_]+\.[a-z_]+", text)}
    assert foreign == set(), path


def test_pages_keep_their_language_without_scripts(visitor: Visitor) -> None:
    page = visitor(java_script_enabled=False, viewport={"width": 320, "height": 640}).new_page()
    page.goto("/de/cameras/")
    expect(page.locator("h1").first).to_have_text("Kameras")
    page.locator("summary", has_text="Kalibrieren").click()
    page.locator("nav a", has_text="Fotos").click()
    page.wait_for_url("**/de/photos/")
    page.locator("footer a", has_text="Українська").click()
    page.wait_for_url("**/uk/photos/")


def test_the_menu_works_by_keyboard_within_a_small_window(page: Page) -> None:
    page.set_viewport_size({"width": 320, "height": 640})
    page.goto("/uk/terms/")
    page.keyboard.press("Tab")
    expect(page.locator(".skip")).to_be_focused()
    page.locator(".menu summary").focus()
    page.keyboard.press("Enter")
    links = page.locator(".menu a")
    expect(links.last).to_be_visible()
    for box in links.evaluate_all("links => links.map((link) => link.getBoundingClientRect().toJSON())"):
        assert box["left"] >= 0
        assert box["right"] <= 320
    page.keyboard.press("Tab")
    expect(links.first).to_be_focused()
    page.keyboard.press("Escape")
    expect(links.first).to_be_hidden()
    expect(page.locator(".menu summary")).to_be_focused()
    assert page.evaluate("document.documentElement.scrollWidth") == 320
