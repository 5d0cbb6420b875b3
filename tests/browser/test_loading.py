"""Messages for files that cannot be loaded."""

from playwright.sync_api import BrowserContext

from tests.helpers.browser.truth import Truth

VIRTUAL = f"/calibrate/?{Truth().query(seed=3)}"


def test_what_cannot_be_loaded_is_said_in_plain_words(context: BrowserContext) -> None:
    page = context.new_page()
    page.route("**/*.wasm", lambda route: route.abort())
    page.goto(VIRTUAL)
    page.locator(
        "#failure", has_text="The board detector could not be loaded. Check the connection"
    ).wait_for()
    page.route("**/config.json", lambda route: route.abort())
    page.goto("/")
    page.locator("#look").click()
    page.locator("#outcome p", has_text="calibDB cannot be reached. Check the connection").wait_for()
