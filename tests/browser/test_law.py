"""Privacy notice, terms and data page."""

import json

from playwright.sync_api import Page, expect

from tests.helpers.browser.pictures import violations
from tests.helpers.browser.specimens import answer, dump, statistics

OPERATOR = {
    "name": "Lens Society",
    "contact": "mailto:lens@society.example",
    "imprint": "Lens Society|1 Optics Road",
}
MINE = "c4-x-0123456789ab-0123456789abcdef0123"


def test_notice_shows_operator_and_receipts(page: Page) -> None:
    page.goto("/privacy/")
    expect(page.locator("#private-copy")).to_contain_text("This is a private copy")
    expect(page.locator("#no-receipts")).to_be_visible()
    kept = [
        {"id": MINE, "camera": "My <i>webcam</i>", "time": 1_790_000_000_000, "receipt": "eyJzIjoi.signed"}
    ]
    page.evaluate("kept => localStorage.setItem('calibdb.receipts', kept)", json.dumps(kept))
    answer(page, "**/config.json", lambda: {"api": "/v1", "token": "cdb_dev_local", "operator": OPERATOR})
    page.set_viewport_size({"width": 320, "height": 700})
    page.emulate_media(color_scheme="dark")
    page.clock.set_fixed_time("2026-11-22T12:00:00Z")
    page.goto("/de/privacy/")
    expect(page.locator("#operator")).to_contain_text("1 Optics Road")
    expect(page.locator("#private-copy")).to_be_hidden()
    expect(page.locator("#receipts a")).to_have_text("My <i>webcam</i>")
    assert MINE in (page.locator("#receipts a").get_attribute("href") or "")
    letter = page.locator("#write").get_attribute("href") or ""
    assert letter.startswith("mailto:lens@society.example?subject=Meine%20Kalibrierungen")
    assert letter.endswith("eyJzIjoi.signed")
    assert page.evaluate("document.documentElement.scrollWidth") <= 320
    assert violations(page) == []
    page.locator("#remove").click()
    expect(page.locator("#receipts li")).to_have_count(0)
    assert page.evaluate("localStorage.getItem('calibdb.receipts')") is None


def test_terms_name_the_text_that_is_agreed_to(page: Page) -> None:
    page.goto("/uk/terms/#data")
    expect(page.locator("code")).to_have_text("2026-11-22")
    expect(page.locator("h1")).to_have_text("Умови користування")
    assert violations(page) == []


def test_data_page_shows_figures_and_files(page: Page) -> None:
    page.goto("/data/")
    expect(page.locator("#status")).to_contain_text("Statistics appear after the first weekly run")
    expect(page.locator("#no-dump")).to_be_visible()
    answer(page, "**/dumps/statistics.json", statistics)
    answer(page, "**/dumps/latest.json", dump)
    page.set_viewport_size({"width": 360, "height": 800})
    page.goto("/de/data/")
    expect(page.locator("#calibrations")).to_have_text("1.330")
    expect(page.locator("#wanted-rows a").first).to_have_text("<b>Doubted</b> (046d:0800)")
    expect(page.locator("#wanted-rows a")).to_have_count(11)
    expect(page.locator("#wanted-rows tr")).to_have_count(12)
    first = dump()["files"][0]
    expect(page.locator(".digest").first).to_have_text(first["sha256"])
    href = page.url.replace("de/data/", "dumps/") + first["name"]
    expect(page.locator("#files a").first).to_have_attribute("href", href)
    expect(page.locator(".chart polyline")).to_have_count(2)
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    assert violations(page) == []
