"""Error messages in the language of the page, with a remedy."""

from playwright.sync_api import BrowserContext, expect

from tests.helpers.browser.pictures import picture

from ..conftest import THOROUGH

PATHS = ("/cameras/?key=c2.none", "/result/?id=none")


def test_faults_in_words_of_the_page(context: BrowserContext) -> None:
    page = context.new_page()
    for path in PATHS if THOROUGH else PATHS[:1]:
        page.goto(f"/de{path}")
        page.locator("#waiting p", has_text="gibt es").wait_for()
        expect(page.locator("#waiting .actions a:visible")).to_have_count(2)
    picture(page, "missing", ["hand"])
