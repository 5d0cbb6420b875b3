"""The landing page."""

from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.pictures import SIZES, violations
from tests.helpers.browser.scenes import CAMERA
from tests.helpers.browser.specimens import answer, cameras, result
from tests.helpers.browser.waiting import passing

DRAWN = "document.querySelector('#loop .black').getAttribute('d')"


def test_code_is_copied_and_a_lookup_shows_a_card(page: Page, context: BrowserContext) -> None:
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    page.add_init_script(CAMERA)
    answer(page, "**/v1/lookup", lambda: result() | {"calibrations": 7, "reliable": True})
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
    page.add_init_script(CAMERA)
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
