"""Change of language in the middle of a task: all texts of the page follow."""

from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.interruptions import ENDLESS
from tests.helpers.browser.scenes import no_network, unreadable
from tests.helpers.browser.waiting import address


def speak(page: Page, language: str) -> None:
    page.locator("#language").select_option(language)


def test_what_the_pages_have_said_is_said_again_in_another_language(page: Page) -> None:
    page.goto("/?lang=en")
    page.locator("#look").click()
    page.locator("#outcome", has_text="No camera was found").wait_for()
    speak(page, "de")
    page.locator("#outcome", has_text="keine Kamera").wait_for()

    page.goto("/cameras/?query=nobodys&lang=en")
    page.locator("#status", has_text="No camera found. Be the first").wait_for()
    speak(page, "uk")
    page.locator("#status", has_text="Камеру не знайдено.").wait_for()

    page.goto("/photos/?lang=en")
    page.locator("#files").set_input_files([unreadable("IMG_0001.HEIC")])
    page.locator("#status", has_text="Browsers cannot read HEIC").wait_for()
    speak(page, "de")
    page.locator("#status", has_text="IMG_0001.HEIC").wait_for()
    expect(page.locator("#status")).not_to_contain_text("cannot")


def test_a_service_that_is_away_is_asked_again_and_what_it_refuses_is_said_in_every_language(
    context: BrowserContext,
) -> None:
    page = context.new_page()  # refused requests are errors in the console
    for path in ("/cameras/?query=c920", "/cameras/?key=c2.none", "/result/?id=none"):
        no_network(page)
        page.goto(f"{path}&lang=en")
        page.locator("[role=status]", has_text="calibDB cannot be reached just now. Trying again.").wait_for()
        page.unroute("**/v1/**")
        page.route("**/v1/**", lambda route: route.fulfill(status=403, json={}))
        page.locator("[role=status]", has_text="does not accept this page's token").wait_for()
        speak(page, "de")
        page.locator("[role=status]", has_text="erkennt diese Seite nicht an").wait_for()
        page.unroute("**/v1/**")


def test_a_language_that_was_chosen_stays_whatever_the_address_asked_for(page: Page) -> None:
    page.goto(f"{ENDLESS}&lang=en")
    page.locator("#undo:enabled").wait_for()
    speak(page, "uk")
    page.reload()
    page.locator("#stop", has_text="Зупинити").wait_for()
    page.goto("/calibrate/?lang=de")
    page.locator("#go-on", has_text="Fortfahren").click()
    page.locator("#controls:not([hidden])").wait_for()
    expect(page.locator("#stop"), "what is gone on with speaks as who goes on").to_have_text("Beenden")
    assert "/de/calibrate/?" in address(page)
