"""The consent block: nobody has ticked it, it is remembered, and it decides what a session says."""

import json
from typing import Any

from playwright.sync_api import Page, expect

from tests.helpers.browser.scenes import BLIND_DETECTOR

CONSENT = {"licence": "CC0-1.0", "licence_version": "2026-11-22"}


def start(page: Page) -> dict[str, Any]:
    """Start the virtual camera, and return what the session's start says of a licence."""
    with page.expect_request(lambda r: r.method == "POST" and r.url.endswith("/v1/session")) as asked:
        page.locator("#start-virtual").click()
    body = json.loads(asked.value.post_data or "")
    return {name: value for name, value in body.items() if name.startswith("licence")}


def test_capture_says_a_licence_only_after_consent(page: Page) -> None:
    page.add_init_script(BLIND_DETECTOR)
    page.goto("/calibrate/?lang=de")
    box, note = page.locator("#consent"), page.locator("#consent-note")
    expect(note).to_contain_text("Nicht angekreuzt: Ihre Kamera wird trotzdem kalibriert")
    expect(box).not_to_be_checked()
    page.goto("/calibrate/?lang=uk")
    expect(note).to_contain_text("Не позначено")
    box.check()
    expect(note).to_contain_text("Дякуємо")
    assert start(page) == CONSENT
    # Kept on this device, for every page that calibrates, until it is taken back.
    page.goto("/photos/?lang=en")
    expect(box).to_be_checked()
    page.goto("/import/")
    expect(box).to_be_checked()
    page.evaluate("document.getElementById('form').hidden = false")
    box.uncheck()
    assert page.evaluate("Object.keys(localStorage).filter((key) => key.includes('consent'))") == [], (
        "as at first"
    )
    page.goto("/calibrate/")
    expect(note).to_contain_text("Not ticked")
    assert start(page) == {}
