"""Landing page, status, privacy notice, terms and data page."""

import json

from playwright.sync_api import BrowserContext, Page, Route, expect

from tests.helpers.browser.pictures import SIZES, picture, violations
from tests.helpers.browser.scenes import webcam
from tests.helpers.browser.specimens import answer, cameras, dump, known, statistics
from tests.helpers.browser.waiting import passing

DRAWN = "document.querySelector('#loop .black').getAttribute('d')"
OPERATOR = {
    "name": "Lens Society",
    "contact": "mailto:lens@society.example",
    "imprint": "Lens Society|1 Optics Road",
}
MINE = "c4-x-0123456789ab-0123456789abcdef0123"


def test_code_is_copied_and_a_lookup_shows_a_card(page: Page, context: BrowserContext) -> None:
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.add_init_script(webcam())
    answer(page, "**/v1/lookup", known)
    answer(page, "**/v1/cameras?*", cameras)
    page.goto("/")
    assert len(page.locator("main").inner_text().split()) <= 300
    with passing(page, ".code .copy", "Copied"):
        page.locator(".code .copy").first.click()
    copied = page.evaluate("navigator.clipboard.readText()")
    assert copied == page.locator(".code code").first.inner_text().strip()
    assert "lookup" in copied
    page.set_viewport_size(SIZES["desk"])
    search = page.get_by_role("searchbox", name="Is your camera in the database?")
    assert (search.bounding_box() or {})["y"] < 850
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
    search.fill("c920")
    search.press("Enter")
    page.wait_for_url("**/cameras/?query=c920", wait_until="commit")


def test_an_unknown_camera_has_an_estimate(page: Page) -> None:
    likely = {
        "img_size": [1280, 720],
        "camera_matrix": [[968.0, 0, 639.5], [0, 968.0, 359.5], [0, 0, 1]],
        "distortion_model": "rectilinear",
        "distortion_coefficients": [0, 0, 0, 0, 0],
        "hfov_deg": 66.9,
        "interval_90": {"hfov_deg": [64.4, 69.5]},
        "basis": "published",
        "sources": [
            {"title": "A data sheet", "url": "https://sheets.example/c920"},
            {"title": "No page", "url": "javascript:alert(1)"},
        ],
    }
    page.add_init_script(webcam())
    miss = {"calibration": None, "reason": "unknown_camera", "guidance_url": "/calibrate/", "detail": "None."}
    answer(page, "**/v1/lookup", lambda: miss | {"estimate": likely})
    answer(page, "**/v1/cameras?*", cameras)
    page.goto("/")
    page.locator("#look").click()
    shown = page.locator(".estimate")
    expect(shown).to_contain_text("Until then: an estimate")
    expect(shown).to_contain_text("about 67°")
    expect(shown).to_contain_text("64° to 70°")
    expect(shown).to_contain_text("published values of this model")
    expect(page.locator(".answer a.primary")).to_have_attribute("href", "/calibrate/")
    addresses = shown.locator("a").evaluate_all("links => links.map((link) => link.getAttribute('href'))")
    assert addresses == ["https://sheets.example/c920", "#"]
    expect(shown).not_to_contain_text("{")
    assert violations(page) == []


def test_what_is_down_is_said_and_what_works_has_its_latency(context: BrowserContext) -> None:
    page = context.new_page()
    parts = [
        {
            "part": name,
            "ok": name != "table",
            "latency_ms": None if name == "table" else 4.0,
            "limit_ms": 2000,
        }
        for name in ("table", "bucket", "edge", "solver")
    ]
    failed = json.dumps({"status": 503, "checked_at": 0, "parts": parts, "canary": None})

    def answer(route: Route) -> None:
        route.fulfill(status=503, body=failed, content_type="application/problem+json")

    page.route("**/healthz?deep=1", answer)
    page.goto("/status/")
    expect(page.locator("#verdict")).to_have_text("A part of the service fails.")
    expect(page.locator("#part-table .state")).to_have_text("fails")
    expect(page.locator("#part-bucket .state")).to_have_text("operational")
    picture(page, "status-down", ["hand"], full=True)
    page.unroute("**/healthz?deep=1")
    page.locator("#again").click()
    expect(page.locator("#verdict")).to_have_text("Everything works.")
    expect(page.locator(".state.ok")).to_have_count(6)
    expect(page.locator("#part-solver td").last).to_contain_text("ms")
    context.set_offline(offline=True)
    expect(page.locator("#verdict")).to_have_text("calibDB cannot be reached.")
    expect(page.locator("#advice")).to_contain_text("Your device has no network")
    context.set_offline(offline=False)
    expect(page.locator("#verdict")).to_have_text("Everything works.")


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
