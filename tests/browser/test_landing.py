"""The landing page: a lookup answers with a card, the database is counted, pictures move where wanted."""

from playwright.sync_api import Page, expect

from tests.helpers.browser.pictures import violations
from tests.helpers.browser.scenes import CAMERA
from tests.helpers.browser.specimens import answer, cameras, result

DRAWN = "document.querySelector('#loop .black').getAttribute('d')"


def test_a_lookup_answers_with_a_card_beside_the_counts_of_the_database(page: Page) -> None:
    page.add_init_script(CAMERA)
    page.emulate_media(reduced_motion="reduce")
    answer(page, "**/v1/lookup", lambda: result() | {"calibrations": 7, "reliable": True})
    answer(page, "**/v1/cameras?*", cameras)
    page.goto("/")
    still = page.evaluate(DRAWN)
    page.locator("#look").click()
    page.locator(".answer h3", has_text="HD Pro Webcam C920 (046d:082d) is ready to use").wait_for()
    expect(page.locator(".answer dl")).to_contain_text("1280\u00a0×\u00a0720")
    expect(page.locator(".answer a").first).to_have_text("Download and details")
    expect(page.locator("#outcome")).not_to_contain_text("{")
    expect(page.locator("#counts li")).to_have_count(3)
    assert violations(page) == []
    assert page.evaluate(DRAWN) == still, "nothing moves for who asks for that"
    page.locator("#loop-toggle").click()
    page.wait_for_function(f"(before) => {DRAWN} !== before", arg=still)
