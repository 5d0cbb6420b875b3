"""Error messages in the language of the page, with a remedy."""

from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.pictures import picture
from tests.helpers.browser.scenes import CAMERA, no_network, unreadable


def test_faults_in_words_of_the_page(context: BrowserContext) -> None:
    page = context.new_page()  # failed requests are errors in the console, and here they are meant to be
    for path in ("/result/?id=none", "/cameras/?key=c2.none"):
        page.goto(f"{path}&lang=de")
        page.locator("#waiting p", has_text="gibt es").wait_for()
        expect(page.locator("#waiting .actions a:visible"), "there are ways on").to_have_count(2)
        picture(page, f"missing-{path.split('/')[1]}", ["hand"])
    page.add_init_script(CAMERA)
    page.goto("/?lang=de")
    no_network(page)
    page.locator("#look").click()
    page.locator("#outcome .problem", has_text="nicht zu erreichen").wait_for()


def test_files_that_cannot_be_read_are_named_with_the_reason(page: Page) -> None:
    page.goto("/photos/?lang=de")
    state = page.locator("#files-state")
    assert state.inner_text() == "Noch nichts gewählt"
    page.locator("#files").set_input_files([unreadable("IMG_1.HEIC"), unreadable("notes.txt", "text/plain")])
    page.locator("#status", has_text="HEIC nicht lesen. Speichern Sie IMG_1.HEIC als JPEG").wait_for()
    page.locator("#status", has_text="Kein Foto und kein Video: notes.txt").wait_for()
    assert state.inner_text() == "2 Dateien gewählt"
