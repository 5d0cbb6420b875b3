"""The consent block."""

from typing import Any

from playwright.sync_api import Page, expect

from tests.helpers.browser.interruptions import PRACTICE
from tests.helpers.browser.scenes import BLIND_DETECTOR

from ..conftest import THOROUGH

SHOW_FORM = "document.getElementById('form').hidden = false"
NOTES = (("de", "Fügt Ihre Eckenmessungen dem öffentlichen Datensatz hinzu"), ("uk", "Додає ваші виміри"))
CONSENT = {"licence": "CC0-1.0", "licence_version": "2026-11-22"}


def start(page: Page) -> dict[str, Any]:
    with page.expect_request(lambda r: r.method == "POST" and r.url.endswith("/v1/session")) as asked:
        page.locator("#start-virtual").click()
    body = asked.value.post_data_json
    return {name: value for name, value in body.items() if name.startswith("licence")}


def test_consent_licenses_a_capture_and_publishes_once(page: Page) -> None:
    page.add_init_script(BLIND_DETECTOR)
    box, note = page.locator("#consent"), page.locator("#consent-note")
    for language, words in NOTES if THOROUGH else NOTES[-1:]:
        page.goto(f"/photos/?lang={language}")
        expect(note).to_contain_text(words)
        expect(box).not_to_be_checked()
    page.evaluate(SHOW_FORM)
    box.check()
    expect(note).to_contain_text("Дякуємо")
    page.goto(f"{PRACTICE}&lang=en")
    expect(box).to_be_hidden()
    assert start(page) == CONSENT
    page.goto("/import/?lang=en")
    expect(box).to_be_checked()
    page.evaluate(SHOW_FORM)
    box.uncheck()
    assert page.evaluate("Object.keys(localStorage).filter((key) => key.includes('consent'))") == [], (
        "as at first: the next capture is without a licence"
    )
    # After a capture it publishes once, and a refusal takes it back.
    page.evaluate("""async () => {
      const { publishOnConsent } = await import("/lib/consent.js");
      window.asked = [];
      publishOnConsent(async () => {
        window.asked.push(localStorage.getItem("calibdb.consent"));
        if (window.asked.length === 1) throw new TypeError("no network");
      });
    }""")
    box.click()
    expect(note).to_contain_text("could not be published")
    expect(box).not_to_be_checked()
    for _ in range(3):
        box.click()
    expect(box).to_be_checked()
    expect(note).to_contain_text("Thank you")
    assert page.evaluate("window.asked") == ["2026-11-22", "2026-11-22"]
