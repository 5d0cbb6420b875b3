"""Information and questions before a capture: sender, consent, phone model."""

from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.helpers.browser.interruptions import PRACTICE
from tests.helpers.browser.pictures import picture, violations
from tests.helpers.browser.scenes import BLIND_DETECTOR
from tests.helpers.browser.specimens import answer, cameras

from ..conftest import THOROUGH

ASKED = "camera=HD+Pro+Webcam+C920+(046d:082d)&img_size=640x480"
SHOW_FORM = "document.getElementById('form').hidden = false"
NOTES = (("de", "Fügt Ihre Eckenmessungen dem öffentlichen Datensatz hinzu"), ("uk", "Додає ваші виміри"))
CONSENT = {"licence": "CC0-1.0", "licence_version": "2026-11-22"}
ASK = """async () => {
  const { askPhoneModel } = await import("/lib/phone-model.js");
  const userAgent = "Mozilla/5.0 (iPhone; CPU iPhone OS 17_5 like Mac OS X)";
  const screen = { width: 390, height: 844, ratio: 3 };
  window.answered = undefined;
  const { signal } = new AbortController();
  void askPhoneModel(signal, { userAgent, screen }).then((id) => { window.answered = id; });
}"""


def test_sender_is_named_and_one_click_away(page: Page) -> None:
    page.add_init_script(BLIND_DETECTOR)
    answer(page, "**/v1/cameras?*", cameras)
    page.goto(f"/calibrate/?{ASKED}&return_to=http://localhost:9000/app?a=b")
    sender = page.locator("#sender")
    expect(sender.locator("p").first).to_have_text(
        "localhost:9000 needs your camera's calibration (HD Pro Webcam C920 (046d:082d), 640 × 480). "
        "It takes about a minute. Then you return to localhost:9000."
    )
    expect(page.locator("#sender-known")).to_contain_text("3 more calibrations are needed")
    expect(page.locator("#go-back")).to_have_attribute("href", "http://localhost:9000/app?a=b")
    expect(page.locator("#wanted")).to_have_text("No camera was found here. Plug it in.")
    expect(page.locator("#camera"), "the virtual camera does not stand in for a real one").to_have_value("")
    picture(page, "capture-sender", ["hand"])
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.getElementById('start').getBoundingClientRect().bottom") < 780
    with page.expect_download() as paper:
        page.locator("#paper").click()
    assert paper.value.suggested_filename == "calibdb-board-letter.pdf"


@pytest.mark.thorough
def test_sender_without_a_result_is_told_before(page: Page) -> None:
    page.add_init_script(BLIND_DETECTOR)
    sender = page.locator("#sender")
    page.goto(f"/calibrate/?{ASKED}&return_to=http://app.example/")
    expect(sender).to_contain_text("this service may not hand the result to app.example")
    expect(page.locator("#go-back")).to_be_hidden()
    page.goto(f"/calibrate/?{ASKED}&return_to=javascript:alert(1)")
    expect(page.locator("#wanted")).to_contain_text("This page was opened for HD Pro Webcam C920")
    expect(sender).to_be_hidden()


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


def test_the_visitor_is_asked_for_the_model_once(page: Page) -> None:
    page.add_init_script(BLIND_DETECTOR)
    page.goto("/calibrate/")
    page.evaluate(ASK)
    dialog = page.locator("dialog")
    expect(dialog).to_contain_text("Which iPhone is this?")
    assert dialog.locator("option").count() == 7
    assert violations(page) == []
    dialog.locator("select").select_option("iPhone 13")
    dialog.locator("button").click()
    page.wait_for_function("window.answered !== undefined")
    assert page.evaluate("window.answered") == "iPhone14,5"
    page.evaluate(ASK)
    page.wait_for_function("window.answered !== undefined")
    assert page.evaluate("window.answered") == "iPhone14,5"
    expect(dialog).to_have_count(0)
