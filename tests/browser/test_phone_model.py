"""The question about an iPhone's model."""

from playwright.sync_api import Page, expect

from tests.helpers.browser.pictures import violations
from tests.helpers.browser.scenes import BLIND_DETECTOR

ASK = """async () => {
  const { askPhoneModel } = await import("/lib/phone-model.js");
  const userAgent = "Mozilla/5.0 (iPhone; CPU iPhone OS 17_5 like Mac OS X)";
  const screen = { width: 390, height: 844, ratio: 3 };
  window.answered = undefined;
  const { signal } = new AbortController();
  void askPhoneModel(signal, { userAgent, screen }).then((id) => { window.answered = id; });
}"""


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
