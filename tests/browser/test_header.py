"""Language and menu of the header."""

from playwright.sync_api import Page, expect

from tests.helpers.browser.waiting import address

from .conftest import Visitor


def test_a_german_visitor_keeps_query_and_choice(visitor: Visitor) -> None:
    page = visitor(locale="de-DE").new_page()
    page.goto("/terms/?query=c920#data")
    page.locator("h1", has_text="Nutzungsbedingungen").wait_for()
    assert address(page).endswith("/de/terms/?query=c920#data")
    page.locator("#language").select_option("en")
    page.locator("nav summary", has_text="Calibrate").wait_for()
    assert "/de/" not in address(page)
    page.goto("/privacy/")
    page.locator("h1", has_text="Privacy").wait_for()
    page.goto("/uk/terms/")
    page.locator("h1", has_text="Умови користування").wait_for()


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
