"""The database to look through."""

import httpx
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.captures import capture, listed
from tests.helpers.browser.pictures import picture
from tests.helpers.browser.specimens import answer, camera, cameras
from tests.helpers.browser.truth import Truth

KEY = {"camera": "Shelf Test Camera (1234:0002)", "platform": "X11; Linux x86_64", "img_size": [1280, 720]}


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_what_is_known_is_drawn(page: Page, scheme: str) -> None:
    page.emulate_media(color_scheme="dark" if scheme == "dark" else "light")
    answer(page, "**/v1/cameras?*", cameras)
    answer(page, "**/v1/cameras/*", camera)
    page.goto("/cameras/")
    page.locator("#found li").first.wait_for()
    expect(page.locator("#found > li")).to_have_count(6)
    expect(page.locator("#found > li", has_text="practice camera, not a real one")).to_have_count(1)
    expect(page.locator("#more")).to_be_visible()
    picture(page, f"cameras-{scheme}")
    page.goto("/cameras/?key=c2.specimen")
    page.locator("#camera-name", has_text="C920").wait_for()
    assert page.locator(".agrees").count() == 2 * (9 + 2)
    assert page.locator("path.cut").count() == 2 * 2, "what does not agree is crossed"
    expect(page.locator(".reliability").first).to_contain_text("known: every web page")
    expect(page.locator(".reliability").last).to_contain_text("too few calibrations")
    captions = page.locator("figcaption").all_text_contents()
    assert ["agreed" in caption for caption in captions] == [True, True, False, False], (
        "where there is none, none is named"
    )
    picture(page, f"camera-{scheme}", full=True)


def test_a_calibrated_camera_is_found_and_fitted_with_any_model(page: Page, api: httpx.Client) -> None:
    capture(api, Truth(), KEY, seed=6)
    listed(api, "shelf test")
    page.goto("/cameras/?query=nobody+has+this")
    page.locator("#status", has_text="calibDB knows no camera of that name").wait_for()
    page.locator("#query").fill("shelf test")
    page.locator("#found a", has_text="Shelf Test Camera").click()
    page.locator("#camera-name", has_text="Shelf Test Camera").wait_for()
    expect(page.locator("h2", has_text="1280 × 720")).to_have_count(1)
    page.locator("select[id^=model-]").select_option("fisheye")
    page.locator("caption", has_text="fisheye").wait_for()
    expect(page.locator("tbody th", has_text="k4")).to_have_count(1)
    expect(page.locator("pre").last).to_contain_text('"camera"')
    page.locator("select[id^=format-model-]").select_option("gyroflow")
    page.locator("button[id^=download-model-]").click()
    page.locator(".saved", has_text="says exactly").wait_for()


def test_of_a_consensus_there_are_no_corners_and_the_page_says_so(
    context: BrowserContext, api: httpx.Client
) -> None:
    page = context.new_page()  # a refusal is an error in the console, and here one is meant to be
    capture(api, Truth(), KEY | {"camera": "Desk Test Camera (1234:0003)"}, seed=8)
    listed(api, "desk test")
    page.goto("/cameras/?query=nobody+has+this")
    page.locator("#status", has_text="calibDB knows no camera of that name").wait_for()
    page.locator("#query").fill("desk test")
    page.locator("#search button").click()
    page.locator("#found a", has_text="Desk Test Camera").click()
    select = page.locator("select[id^=format-model-]")
    select.wait_for()
    select.select_option("corners-vnl")
    page.locator("button[id^=download-model-]").click()
    page.locator(".saved.problem", has_text="no corners of its own").wait_for()
    picture(page, "camera-refused", ["hand"], full=True)


def test_what_is_not_there_is_said(page: Page) -> None:
    page.goto("/cameras/?query=nobody+has+this")
    page.locator("#status", has_text="calibDB knows no camera of that name").wait_for()
