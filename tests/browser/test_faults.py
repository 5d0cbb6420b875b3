"""Error messages in the language of the page, with a remedy."""

import json

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.pictures import picture
from tests.helpers.browser.scenes import CAMERA, no_network, unreadable

SAID = {
    "de": {
        "camera": "keine Kamera gefunden",
        "offline": "nicht zu erreichen",
        "none": "gibt es",
        "refused": "erkennt diese Seite nicht an",
    },
    "uk": {
        "camera": "Камери не знайдено",
        "offline": "недоступна",
        "none": "немає",
        "refused": "не визнає цю сторінку",
    },
}


@pytest.mark.parametrize("language", ["de", pytest.param("uk", marks=pytest.mark.thorough)])
def test_faults_in_words_of_the_page(context: BrowserContext, language: str) -> None:
    # Failed requests are errors in the console, and here they are meant to be.
    said = SAID[language]
    page = context.new_page()
    page.goto(f"/?lang={language}")
    page.locator("#look").click()
    page.locator("#outcome .problem", has_text=said["camera"]).wait_for()
    assert (page.locator("#outcome a").get_attribute("href") or "").endswith("/cameras/")

    for path in ("/result/?id=none", "/cameras/?key=c2.none"):
        page.goto(f"{path}&lang={language}")
        page.locator("#waiting p", has_text=said["none"]).wait_for()
        expect(page.locator("#waiting .actions a:visible"), "there are ways on").to_have_count(2)
        picture(page, f"missing-{path.split('/')[1]}-{language}", ["hand"])

    page = context.new_page()
    problem = json.dumps({"title": "Forbidden", "status": 403, "detail": "The API token is not valid."})
    page.route(
        "**/v1/**", lambda route: route.fulfill(status=403, body=problem, content_type="application/json")
    )
    page.goto(f"/cameras/?lang={language}")
    page.locator("#status", has_text=said["refused"]).wait_for()
    assert "token is not valid" not in (page.locator("main").inner_text())

    page = context.new_page()
    page.add_init_script(CAMERA)
    page.goto(f"/?lang={language}")
    no_network(page)
    page.locator("#look").click()
    page.locator("#outcome .problem", has_text=said["offline"]).wait_for()


def test_files_that_cannot_be_read_are_named_with_the_reason(page: Page) -> None:
    page.goto("/photos/?lang=de")
    state = page.locator("#files-state")
    assert state.inner_text() == "Noch nichts gewählt"
    page.locator("#files").set_input_files([unreadable("IMG_1.HEIC"), unreadable("notes.txt", "text/plain")])
    page.locator("#status", has_text="HEIC nicht lesen. Speichern Sie IMG_1.HEIC als JPEG").wait_for()
    page.locator("#status", has_text="Kein Foto und kein Video: notes.txt").wait_for()
    assert state.inner_text() == "2 Dateien gewählt"
