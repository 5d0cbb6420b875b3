"""The pages of known cameras."""

import json
import re
from typing import Any

import httpx
import pytest
from playwright.sync_api import BrowserContext, Download, Page, expect

from tests.helpers.browser.captures import capture, listed
from tests.helpers.browser.pictures import SIZES, picture
from tests.helpers.browser.specimens import answer, camera, cameras, result, result_of_camera
from tests.helpers.browser.truth import Truth
from tests.helpers.browser.waiting import address, uncaught

KEY = {"camera": "Shelf Test Camera (1234:0002)", "platform": "X11; Linux x86_64", "img_size": [1280, 720]}
APART = "How far apart the two show a point: typically"


def test_what_is_known_is_drawn(page: Page) -> None:
    answer(page, "**/v1/cameras?*", cameras)
    answer(page, "**/v1/cameras/*", camera)
    answer(page, "**/v1/calibrations/*", result)
    page.goto("/cameras/")
    page.locator("#found tr").first.wait_for()
    expect(page.locator("#found > tr")).to_have_count(6)
    expect(page.locator("#found > tr", has_text="simulated camera, for practice")).to_have_count(1)
    expect(page.locator("#found > tr").first).to_contain_text("Linux · USB 046d:082d")
    expect(page.locator("#found > tr", has_text="2 of 5 calibrations")).to_have_count(6)
    expect(page.locator("#found > tr").first).to_contain_text("66°")
    expect(page.locator("#found .ring").first.locator(".there")).to_have_count(5)
    expect(page.locator("#more")).to_be_visible()
    names = page.locator("#found strong")
    page.set_viewport_size(SIZES["desk"])
    for button, order in (("Camera", "ascending"), ("Camera", "descending"), ("Width of view", "descending")):
        page.get_by_role("button", name=button).click()
        head = page.get_by_role("columnheader", name=button)
        expect(head).to_have_attribute("aria-sort", order)
        expect(page.locator("[aria-sort]")).to_have_count(1)
        if button == "Camera":
            ascending = sorted(names.all_text_contents(), key=str.lower)
            assert names.all_text_contents() == ascending[:: 1 if order == "ascending" else -1]
    picture(page, "cameras")
    page.goto("/cameras/?key=c2.specimen")
    page.locator("#camera-name", has_text="C920").wait_for()
    bar = page.locator(".pinned")
    expect(bar.locator("strong")).to_be_hidden()
    expect(page.locator(".reliability").first).to_contain_text("Ready to use")
    expect(page.locator(".reliability").last).to_contain_text("2 of 5 calibrations")
    page.locator(".mode > summary").last.click()
    page.locator(".mode").last.get_by_text("Too few calibrations yet.").wait_for()
    assert page.locator(".agrees").count() == 2 * 9
    assert page.locator("path.cut").count() == 2 * 2
    expect(page.locator(".plot a").first).to_have_attribute("href", re.compile(r"result/\?id=m\d"))
    expect(page.locator("td.std").first).to_contain_text("± 2.5")
    page.mouse.wheel(0, 700)
    expect(bar.locator("strong")).to_have_text("HD Pro Webcam C920")
    expect(bar).to_contain_text("Ready to use")
    assert bar.evaluate("(bar) => bar.getBoundingClientRect().top") == 0
    captions = page.locator("figcaption").all_text_contents()
    assert [caption for caption in captions if "consensus" in caption] == captions[-2:]
    boxes = page.locator(".members input[type=checkbox]")
    boxes.nth(0).check()
    boxes.nth(1).check()
    expect(boxes.nth(2)).to_be_disabled()
    expect(page.locator(".comparison figcaption")).to_contain_text(APART)
    picture(page, "camera", full=True)
    boxes.nth(1).uncheck()
    expect(page.locator(".comparison figcaption")).to_have_count(0)


def test_a_calibrated_camera_is_found_and_fitted_with_any_model(
    context: BrowserContext, api: httpx.Client
) -> None:
    page = context.new_page()
    errors = uncaught(page)
    capture(api, Truth(), KEY, seed=6)
    listed(api, "shelf test")
    page.goto("/cameras/?query=nobody+has+this")
    page.locator("#status", has_text="No camera found").wait_for()
    expect(page.locator("#calibrate-first")).to_be_visible()
    page.locator("#query").fill("shelf test")
    page.locator("#found a", has_text="Shelf Test Camera").wait_for()
    assert "query=shelf+test" in address(page)
    page.locator("#found a", has_text="Shelf Test Camera").click()
    page.locator("#camera-name", has_text="Shelf Test Camera").wait_for()
    call = page.locator("#calibrate-this")
    expect(page.locator("#missing")).to_contain_text("4 more calibrations needed at 1280")
    assert "/calibrate/?camera=Shelf+Test+Camera" in (call.get_attribute("href") or "")
    assert "img_size=1280x720" in (call.get_attribute("href") or "")
    expect(page.locator("h2", has_text="1280 × 720")).to_have_count(1)
    page.locator("select[id^=model-]").select_option("fisheye")
    page.locator("caption", has_text="fisheye").wait_for()
    expect(page.locator("tbody th", has_text="k4")).to_have_count(1)
    expect(page.locator("pre").last).to_contain_text('"camera"')
    page.locator("select[id^=format-model-]").select_option("gyroflow")
    page.locator("button[id^=download-model-]").click()
    page.locator(".saved", has_text="says exactly").wait_for()
    saved: list[Download] = []
    page.on("download", lambda download: saved.append(download))
    page.locator("select[id^=format-model-]").select_option("corners-vnl")
    page.locator("button[id^=download-model-]").click()
    page.locator(".saved.problem", has_text="no corners of its own").wait_for()
    page.locator("select[id^=format-model-]").select_option("ros")
    expect(page.locator(".saved")).to_have_text("")
    assert saved == []
    page.go_back()
    expect(page.locator("#query")).to_have_value("shelf test")
    assert errors == []


def one_per_cent_longer() -> dict[str, Any]:
    (fx, *first), second, third = result()["camera_matrix"]
    return result() | {"camera_matrix": [[fx * 1.01, *first], second, third]}


def test_own_calibrations_are_compared_and_removed(page: Page) -> None:
    answer(page, "**/v1/cameras/*", camera)
    for name in ("a", "c1-example"):
        answer(page, f"**/v1/calibrations/{name}", result_of_camera)
    answer(page, "**/v1/calibrations/b", one_per_cent_longer)
    page.goto("/mine/")
    expect(page.locator(".nothing")).to_contain_text("Nothing here yet")
    page.evaluate(
        """() => import("/lib/own-calibrations.js").then(({ keepOwn }) => ["a", "b"].forEach((id) => keepOwn({
          id, camera: `Own ${id} (1234:0001)`, img_size: [640, 480], time: 1767225600, level: "good", rms: 1,
        })))"""
    )
    page.goto("/mine/?with=c1-example")
    expect(page.locator("#own li")).to_have_count(3)
    expect(page.locator("#own input:checked")).to_have_count(1)
    expect(page.locator("#own li button")).to_have_count(2)
    compared, caption = page.locator(".comparison thead"), page.locator(".comparison figcaption")
    file, one = page.locator("#with-file"), json.dumps(one_per_cent_longer()).encode()
    file.set_input_files({"name": "camera.json", "mimeType": "", "buffer": one})
    expect(caption).to_contain_text(APART)
    typical = float(re.findall(r"typically ([\d.]+)", caption.text_content() or "")[0])
    assert typical == pytest.approx(3.7, rel=0.15)
    expect(compared).to_contain_text("camera.json")
    file.set_input_files({"name": "no.txt", "mimeType": "text/plain", "buffer": b""})
    expect(page.locator("#own [role=status]")).to_contain_text("No camera was found in this file")
    page.locator("#tick-c1-example").uncheck()
    expect(page.locator("#own li", has_text="Own b")).to_contain_text("640\u00a0×\u00a0480")
    expect(page.locator("#own li a", has_text="Own b")).to_have_attribute(
        "href", re.compile(r"/result/\?id=b$")
    )
    page.locator("#tick-a").check()
    page.locator("#with-consensus").click()
    expect(compared).to_contain_text("Consensus")
    page.locator("#tick-b").check()
    expect(caption).to_contain_text(APART)
    row = page.locator(".comparison tbody tr").first
    expect(row).to_contain_text("σ")
    apart = float(re.findall(r"([\d.]+)\s*σ", row.text_content() or "")[0])
    std = result()["report"]["std"]["fx"]
    assert apart == pytest.approx(0.01 * result()["camera_matrix"][0][0] / (std * 2**0.5), rel=0.02)
    picture(page, "mine-compared", ["desk", "hand"], full=True)
    page.locator("#own li button").first.click()
    expect(page.locator("#own li button")).to_have_count(1)
    page.locator("#own li button").click()
    expect(page.locator("#own li button")).to_have_count(0)
    assert page.evaluate("localStorage.getItem('calibdb.own')") is None
