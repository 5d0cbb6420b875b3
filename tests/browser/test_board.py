"""The board on screens, other devices and paper."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from playwright.sync_api import Page, ViewportSize, expect

from tests.helpers.browser.pictures import SIZES, picture, shot
from tests.helpers.browser.scenes import BLIND_DETECTOR
from tests.helpers.browser.scripts import page_function
from tests.helpers.browser.waiting import address, until
from tests.helpers.marks import thorough

from ..conftest import THOROUGH

PHONE = """
  navigator.mediaDevices.enumerateDevices = async () => [{ kind: "videoinput", deviceId: "", label: "" }];
  navigator.mediaDevices.getUserMedia = async ({ video }) => {
    window.asked = video;
    throw new DOMException("", "NotAllowedError");
  };
"""
FOUND = page_function("find_drawn_boards")


def test_a_board_is_printed_with_words_of_the_page(page: Page) -> None:
    page.goto("/board/?lang=en")
    expect(page.locator("#papers a")).to_contain_text("Letter")
    page.locator("#more-papers summary").click()
    for language, pictures in (("en", 0), ("de", 0), ("uk", 3)):
        page.locator("#language").select_option(language)
        expect(page.locator("html")).to_have_attribute("lang", language)
        with page.expect_download() as download:
            page.locator(".papers a", has_text="A4").click()
        assert download.value.suggested_filename == "calibdb-board-a4.pdf"
        content = Path(download.value.path()).read_bytes()
        assert content.startswith(b"%PDF-1.4")
        assert (b"100\xa0mm when printed" in content) == (language == "en")
        assert (b"Kleben" in content or b"kleben" in content) == (language == "de")
        # Letters that the font of every viewer lacks are pictures, with black in each.
        masks = re.findall(rb"/ImageMask true .*? stream", content.replace(b"\n", b" "))
        assert len(masks) == pictures
        assert len(content) < 300_000
        for mask in re.findall(rb"/Length (\d+) >>\nstream\n", content)[1:]:
            assert int(mask) > 1000


def test_board_fills_the_window_without_full_screen(page: Page) -> None:
    page.add_init_script("delete Element.prototype.requestFullscreen")
    page.set_viewport_size(SIZES["hand"])
    before = "/config.json"
    page.goto(before)
    page.goto("/board/")
    canvas = page.locator("#board")
    page.locator("#full-screen").click()
    page.locator("#frame.filling").wait_for()
    assert page.evaluate("getComputedStyle(document.documentElement).overflowY") == "hidden"
    picture(page, "board-filling", ["hand"])

    def is_turned() -> bool:
        box = canvas.bounding_box()
        assert box is not None
        return box["height"] > box["width"] and (box["height"] > 0.65 * 844 or box["width"] > 0.9 * 390)

    until(page, is_turned)
    canvas.click()
    page.locator("#frame:not(.filling)").wait_for()
    for _ in range(2):
        page.locator("#full-screen").click()
        page.locator("#frame.filling").wait_for()
        page.evaluate("history.back()")
        page.locator("#frame:not(.filling)").wait_for()
        assert page.url.endswith("/board/")
    page.locator("#full-screen").click()
    page.locator("#frame.filling").wait_for()
    page.keyboard.press("Escape")
    page.locator("#frame:not(.filling)").wait_for()
    until(page, lambda: page.evaluate("!history.state?.isBoardFull"))
    page.go_back()
    assert page.url.endswith(before)


def test_any_board_can_be_set_and_goes_along(page: Page) -> None:
    asked = "kind=aprilgrid&squares=5x4&dictionary=DICT_APRILTAG_36h11&tag_spacing=0.25"
    page.goto(f"/board/?{asked}")
    expect(page.locator("#description")).to_have_text("5 × 4 AprilGrid, DICT_APRILTAG_36h11, gaps 0.25")
    expect(page.locator("#columns")).to_have_value("5")
    expect(page.locator("#ratio")).to_be_hidden()
    page.locator("#columns").fill("6")
    assert address(page).endswith(f"/board/?{asked.replace('5x4', '6x4')}")
    page.locator("#more-papers summary").click()
    with page.expect_download() as download:
        page.locator(".papers a", has_text="A4").click()
    assert b"AprilGrid" in Path(download.value.path()).read_bytes()
    page.locator("#board-kind").select_option("chessboard")
    assert address(page).endswith("/board/?kind=chessboard&squares=6x4")
    expect(page.locator("#use")).to_have_attribute(
        "href", re.compile(r"/calibrate/\?kind=chessboard&squares=6x4$")
    )
    page.locator("#board-kind").select_option("charuco")
    page.locator("#columns").fill("7")
    page.locator("#rows").fill("5")
    page.locator("#dictionary").select_option("DICT_6X6_250")
    page.locator("#ratio").fill("0.7")
    page.locator("#legacy").check()
    page.locator("#description", has_text="7 × 5 ChArUco, DICT_6X6_250, markers 0.70").wait_for()
    asked = "squares=7x5&marker_ratio=0.7&dictionary=DICT_6X6_250&legacy=true"
    assert address(page).endswith(f"/board/?{asked}")
    for where in ("calibrate", "photos"):
        hrefs = page.locator(f"a[href*='/{where}/']").evaluate_all("links => links.map((link) => link.href)")
        assert hrefs, where
        assert all(href.endswith(f"/{where}/?{asked}") for href in hrefs), where
    page.locator("#columns").fill("2")
    page.locator("#board-problem", has_text="3 to 50").wait_for()
    expect(page.locator("#description")).to_contain_text("7 × 5")
    page.locator("#reset").click()
    page.locator("#description", has_text="9 × 6").wait_for()
    assert address(page).endswith("/board/")

    page.add_init_script(BLIND_DETECTOR)
    page.goto(f"/calibrate/?{asked}")
    back = page.locator("a[href*='board/']").evaluate_all("links => links.map((link) => link.href)")
    assert len(back) >= 4, back
    assert all(there.removesuffix("#phone-camera").endswith(f"/board/?{asked}") for there in back)
    for path in ("/board/", "/calibrate/"):
        page.goto(f"{path}?squares=12x12")
        expect(page.locator("#problem")).to_contain_text("the board needs 72")
    picture(page, "capture-impossible-board", ["hand"])


@pytest.mark.parametrize(
    ("kind", "flag"),
    [
        ("asymmetric_circles", cv2.CALIB_CB_ASYMMETRIC_GRID),
        *thorough(("circles", cv2.CALIB_CB_SYMMETRIC_GRID)),
    ],
)
def test_circles_are_drawn_and_the_command_is_named(page: Page, kind: str, flag: int) -> None:
    page.goto("/board/")
    page.locator("#preset").select_option("other")
    expect(page.locator("#board-kind")).to_be_focused()
    page.locator("#board-kind").select_option(kind)
    for name, value in (("columns", "4"), ("rows", "11"), ("ratio", "0.5")):
        page.locator(f"#{name}").fill(value)
    page.locator("#description", has_text="4 × 11 circles").wait_for()
    drawn = shot(page.locator("#board"), cv2.IMREAD_GRAYSCALE)
    complete, centres = cv2.findCirclesGrid(drawn, (4, 11), flags=flag)
    assert complete
    steps = np.linalg.norm(np.diff(centres.reshape(11, 4, 2), axis=1), axis=2)
    assert steps.std() / steps.mean() < 0.02
    command = f"calibdb calibrate photos/ --offline --kind {kind} --squares 4x11 --marker-ratio 0.5"
    expect(page.locator(".command code")).to_have_text(command)
    expect(page.locator("#use")).to_be_hidden()
    expect(page.locator("#papers a")).not_to_have_count(0)
    picture(page, f"board-{kind}", ["hand"], full=True)
    page.add_init_script(BLIND_DETECTOR)
    for path in ("/photos/", "/calibrate/") if THOROUGH else ():
        page.goto(f"{path}?kind={kind}&squares=4x11&marker_ratio=0.5")
        expect(page.locator("#problem, #board-problem").filter(has_text=command).first).to_be_visible()


@pytest.mark.thorough
def test_boards_of_every_dictionary_are_found(page: Page) -> None:
    page.goto("/board/")
    offered = page.locator("#dictionary option").all_text_contents()
    kinds = [name for name in offered if name.endswith("_1000") or "APRILTAG" in name]
    assert len(kinds) == 8
    corners = [(8 * y + x, 79.5 + 50 * x, 79.5 + 50 * y) for y in range(5) for x in range(8)]
    drawn = page.evaluate(FOUND, kinds)
    assert len(drawn) == len(kinds)
    for name, found in drawn.items():
        assert np.abs(np.array(found) - corners).max() < 0.05, name


def test_qr_codes_lead_to_another_device(page: Page) -> None:
    page.add_init_script("delete Element.prototype.requestFullscreen")
    page.goto("/board/?squares=8x5")
    page.locator("#qr path").wait_for(state="attached")
    code = shot(page.locator("#qr"), cv2.IMREAD_GRAYSCALE)
    there, _, _ = cv2.QRCodeDetectorAruco().detectAndDecode(cv2.resize(code, None, fx=3, fy=3))
    assert there.endswith("/board/?squares=8x5&fill=1")
    page.set_viewport_size(SIZES["hand"])
    page.goto(there)
    page.locator("#frame.filling").wait_for()
    # One canvas pixel is one device pixel, and the board's cells are whole ones.
    canvas = page.locator("#board")
    wide = "canvas => canvas.getBoundingClientRect().width === canvas.width / devicePixelRatio"
    until(page, lambda: canvas.evaluate(wide))
    canvas.click()
    page.locator("#frame:not(.filling)").wait_for()
    # This screen shows a code for a phone that is to be calibrated with it.
    for width, height in ((1280, 720), *(((768, 1024),) if THOROUGH else ())):
        page.set_viewport_size(ViewportSize(width=width, height=height))
        page.locator("#full-screen-code").click()
        page.locator("#code path").wait_for(state="attached")
        page.evaluate("document.getElementById('hint').hidden = true")  # as after six seconds
        shown = shot(page, cv2.IMREAD_GRAYSCALE)
        _, ids, _, _ = cv2.aruco.CharucoDetector(
            cv2.aruco.CharucoBoard(
                (8, 5), 1.0, 0.65, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
            )
        ).detectBoard(shown)
        assert len(ids) == 28, "the code leaves the board as it is"
        # The other detector misses a code in thirty, whatever the address's port makes of it.
        there, _, _ = cv2.QRCodeDetectorAruco().detectAndDecode(cv2.resize(shown, None, fx=2, fy=2))
        assert there.endswith("/calibrate/?squares=8x5&facing=environment&surface=screen"), (width, height)
        page.keyboard.press("Escape")
    page.add_init_script(PHONE + BLIND_DETECTOR)
    page.set_viewport_size(SIZES["hand"])
    page.goto(there)
    expect(page.locator("#on-other-screen")).to_be_visible()
    expect(page.locator("#ways")).to_be_hidden()
    expect(page.locator("#camera option").first).to_have_text("Rear camera")
    picture(page, "capture-phone", ["hand"])
    page.locator("#start").click()
    until(page, lambda: page.evaluate("window.asked?.facingMode") == {"ideal": "environment"})
