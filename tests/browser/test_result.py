"""The page of a calibration."""

import json
import re
from pathlib import Path
from typing import Any

import cv2
import httpx
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Download, Page, ViewportSize, expect

from calibsolver.formats import FORMAT_NAMES
from tests.helpers.browser.captures import capture
from tests.helpers.browser.photographs import textured_board
from tests.helpers.browser.pictures import SIZES, picture
from tests.helpers.browser.scripts import page_function
from tests.helpers.browser.specimens import answer, camera, result, result_of_camera
from tests.helpers.browser.truth import Truth
from tests.helpers.browser.waiting import shown_calibration, until
from tests.helpers.marks import thorough

from ..conftest import THOROUGH

FORMAT_KEY = "calibdb.format"
COPIED = {"en": "Copied", "de": "Kopiert", "uk": "Скопійовано"}
MAX_HEIGHTS = {"desk": 1800, "hand": 2800}  # px, of a result whichever tab is open
#: formats that are saved in `make test`: tests/service/test_export.py has them all
SAVED = ("calibdb", "ros", "gltf")
KEY = {"camera": "Result Test Camera (1234:0001)", "platform": "X11; Linux x86_64", "img_size": [1280, 720]}


@pytest.mark.parametrize("language", ["uk", *thorough("en", "de")])
def test_a_result_is_short_and_its_card_copies(page: Page, context: BrowserContext, language: str) -> None:
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    answer(page, "**/v1/calibrations/*", result_of_camera)
    answer(page, "**/v1/cameras/*", camera)
    page.goto(f"/{'' if language == 'en' else f'{language}/'}result/?id=x")
    page.get_by_role("tab").first.wait_for()
    page.evaluate("document.fonts.ready.then(() => null)")
    for size, most in MAX_HEIGHTS.items():
        page.set_viewport_size(SIZES[size])
        heights = {}
        for tab in page.get_by_role("tab").all():
            tab.click()
            heights[tab.text_content()] = page.evaluate("document.documentElement.scrollHeight")
        assert max(heights.values()) <= most, heights

    def copied(button: str) -> str:
        page.locator(button).click()
        page.locator(button, has_text=COPIED[language]).wait_for()
        return str(page.evaluate("navigator.clipboard.readText()"))

    assert copied("#copy-link").endswith(f"/result/?id={result()['id']}")
    page.locator("#tab-numbers").click()
    names: dict[str, Any] = {"np": np}
    exec(copied("#copy-numpy"), names)
    assert names["K"].tolist() == result()["camera_matrix"]
    assert names["D"].tolist() == list(result()["distortion_coefficients"])
    values = {"K": result()["camera_matrix"], "D": result()["distortion_coefficients"]}
    assert json.loads(copied("#copy-json")) == values
    ar = page.locator("#to-ar").get_attribute("href") or ""
    assert ("/ar/?camera=" if language == "en" else f"/{language}/ar/?camera=") in ar
    assert "#calibration=c1-example" in ar
    page.locator("#format").select_option("ros")
    assert page.evaluate(f"localStorage.getItem('{FORMAT_KEY}')") == "ros"


def test_a_result_with_its_report_and_a_picture_to_straighten(page: Page, tmp_path: Path) -> None:
    answer(page, "**/v1/calibrations/*", result_of_camera)
    answer(page, "**/v1/cameras/*", camera)
    page.add_init_script(f"localStorage.setItem('{FORMAT_KEY}', 'ros')")
    page.goto("/result/?id=x")
    page.locator("#verdict", has_text="Fair").wait_for()
    expect(page.locator("#format")).to_have_value("ros")
    compare = page.locator(".more").get_by_role("link", name="Compare", include_hidden=True)
    expect(compare).to_have_attribute("href", re.compile(r"/mine/\?with=c1-example"))
    expect(page.locator(".reasons li")).to_have_count(2)
    expect(page).to_have_title("Example Camera 1280\u00a0×\u00a0720: Fair · calibDB")
    expect(page.locator(".card .lead")).to_contain_text("Typical error 0.23\u00a0px, at most 0.41\u00a0px")
    page.locator("#distance").select_option("10")
    expect(page.locator(".meaning output")).to_have_text("that is 2.3\u00a0mm, or 0.013°.")
    expect(page.locator(".facts")).to_contain_text("12 views · ChArUco 9\u00a0×\u00a06 · Jan 1, 2026")
    expect(page.locator("#agreement")).to_contain_text("Ready to use: 9 calibrations agree.")
    assert page.locator("svg.heat path.heat-5").get_attribute("d")
    expect(page.locator(".compare canvas")).to_have_count(2)
    order = page.locator("h2").evaluate_all("all => all.map((each) => each.id)")
    assert order == ["result-error", "result-coverage", "result-poses"]
    page.locator("svg.heat").first.hover()
    expect(page.locator(".tile figcaption").first).to_contain_text("At x = ")
    expect(page.locator(".scene .board")).to_have_count(12)
    page.get_by_role("tab", name="Numbers").focus()
    page.keyboard.press("ArrowRight")
    expect(page.get_by_role("tab", name="Lens")).to_be_focused()
    expect(page.locator(".distortion")).to_be_visible()
    page.locator("#tab-views").click()
    worst = page.locator(".views li strong").first
    expect(worst).to_have_text("View 5")
    worst.hover()
    expect(page.locator(".lit")).to_have_count(3)
    expect(page.locator(".views li")).to_have_count(12)
    expect(page.locator(".views .problem")).to_have_count(3)
    expect(page.locator("td.std").first).to_contain_text("±")
    picture(page, "result", full=True)

    photograph = tmp_path / "photograph.jpg"
    cv2.imwrite(str(photograph), textured_board((1280, 720)))
    sent: list[str] = []
    page.on("request", lambda request: sent.append(request.url))
    page.locator("#trial-picture").set_input_files(photograph)
    page.get_by_text("A square grid as your lens").wait_for(state="detached")
    page.locator(".compare canvas").nth(1).wait_for()
    page.locator(".compare input").fill("20")
    assert page.locator(".compare").evaluate("stage => stage.style.getPropertyValue('--cut')") == "0.2"
    assert [url for url in sent if not url.startswith("blob:")] == []


SHOWN_TWICE = page_function("show_twice")


def test_late_error_bars_move_no_number(page: Page) -> None:
    answer(page, "**/v1/calibrations/*", result)
    page.goto("/result/")
    page.locator("#waiting a").first.wait_for()
    wider = (SIZES["desk"], ViewportSize(width=800, height=600)) if THOROUGH else ()
    for size in (*wider, SIZES["hand"]):
        page.set_viewport_size(size)
        (before, nothing), (after, numbers) = page.evaluate(SHOWN_TWICE)
        assert before == after, size
        assert nothing == [], "no number is read that is rewritten a moment later"
        assert numbers[:2] == ["977.73\u00a0px", "±\u00a00.56\u00a0px"]


def test_a_calibration_is_shown_saved_and_refitted(page: Page, api: httpx.Client) -> None:
    state = capture(api, Truth(), KEY, seed=7)
    path = f"/calibrations/{state['calibration_id']}"
    page.goto(f"/result/?id={state['calibration_id']}")
    page.locator("#agreement", has_text=re.compile("[1-4] of 5 calibrations needed")).wait_for()
    assert shown_calibration(page)["camera"] == KEY["camera"]
    assert "/calibrate/?camera=Result+Test" in (page.locator("#confirm").get_attribute("href") or "")
    formats = [each.get_attribute("value") or "" for each in page.locator("#format option").all()]
    labels = page.locator("#format option").all_text_contents()
    assert formats == list(FORMAT_NAMES)
    assert len(set(labels)) == len(formats)
    assert not set(labels) & set(formats)
    said: dict[str, str] = {}
    kept: list[Download] = []
    page.on("download", lambda download: kept.append(download))
    for form in formats:
        page.locator("#format").select_option(form)
        assert not (page.locator("#format-about").text_content() or "").startswith("formats.")
        if form not in SAVED and not THOROUGH:
            continue
        before = len(kept)
        page.locator("#download").click()
        page.locator(".saved", has_text="Saved as").wait_for()
        said[form] = page.locator(".saved").text_content() or ""
        until(page, lambda n=before: len(kept) > n)
        assert len(kept) == before + 1
        assert f"Saved as {kept[-1].suggested_filename}" in said[form]
        assert kept[-1].suggested_filename.startswith("result-test-camera-1234-0001-1280x720")
        answer_ = api.get(path, params={"format": form}).raise_for_status()
        saved = Path(kept[-1].path()).read_bytes()
        if form == "calibdb":
            assert json.loads(saved)["camera_matrix"] == state["calibration"]["camera_matrix"]
        else:
            assert saved == answer_.content
        assert ("up to" in said[form]) == (float(answer_.headers["x-conversion-error"]) > 0.1)
    assert all("says exactly" in said[form] for form in SAVED if form != "gltf")
    assert "cannot hold the lens exactly" in said["gltf"], "two numbers are a centred pinhole"

    less = api.get(path, params={"without": "0"}).json()
    page.locator("#tab-views").click()
    page.locator("#view-0-out").click()
    page.locator(".trial", has_text="without view 1").wait_for()
    expect(page.locator("#view-0-out:focus")).to_have_text("Include")
    assert shown_calibration(page)["camera_matrix"] == less["camera_matrix"]
    rms, rms_less = (each["uncertainty"]["rms"] for each in (state["calibration"], less))
    assert rms_less > rms
    status = page.locator("#without-status").text_content() or ""
    errors = [float(value) for value in re.findall(r"([\d.]+)\spx[;.]", status)[:2]]
    assert errors == pytest.approx([rms_less, rms], rel=0.05)
    page.locator("#format").select_option("ros")
    page.locator("#download").click()
    page.locator(".saved", has_text="Saved as").wait_for()
    picture(page, "result-without", full=True)
    until(page, lambda: len(kept) > len(said))
    saved = Path(kept[-1].path()).read_bytes()
    assert saved == api.get(path, params={"without": "0", "format": "ros"}).content
    page.locator("#view-1-out").click()
    page.locator("#view-1-out", has_text="Include").wait_for()
    page.locator("#all-again").click()
    page.locator(".trial").wait_for(state="detached")
    assert shown_calibration(page)["id"] == state["calibration_id"]


def test_results_return_over_https_or_to_this_machine(page: Page) -> None:
    six = {
        "calibrations": 6,
        "contributors": 4,
        "reliable": True,
        "id": "c~1280x720~0~rectilinear",
        "report": None,
    }
    answer(page, "**/v1/calibrations/*", lambda: result() | six)
    page.goto("/result/?id=c&return_to=http://127.0.0.1:9/app%3Fscene=2")
    link = page.locator("#return")
    link.wait_for()
    address = link.get_attribute("href") or ""
    assert address.startswith("http://127.0.0.1:9/app?scene=2#calibration=c%7E1280x720")
    summary = page.locator("#summary")
    expect(summary).to_have_text("6 calibrations agree on this. Any web page can look this camera up.")
    page.goto("/result/?id=c&return_to=http://plain.example/")
    page.locator(".return.problem", has_text="plain.example").wait_for()
    expect(page.locator("#return")).to_have_count(0)
