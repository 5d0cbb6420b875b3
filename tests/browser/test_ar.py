"""The AR page: its camera, and its overlays, measured in pictures."""

import re
from typing import Any
from urllib.parse import parse_qs, urlsplit

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from playwright.sync_api import BrowserContext, Page, Request, expect

from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.interruptions import UNPLUG
from tests.helpers.browser.pictures import picture
from tests.helpers.browser.scenes import BLIND_DETECTOR, LISTED_LATE, PLUG, PLUGGED, webcam
from tests.helpers.browser.scripts import PLAIN, page_function
from tests.helpers.browser.specimens import answer, known, result
from tests.helpers.browser.waiting import until
from tests.helpers.marks import thorough

from .test_rectifier import decoded

Array = npt.NDArray[np.float64]

#: a detector that stops to answer when `isSilent` is set; the next one answers
SILENCED = """
  window.Worker = class extends Worker {
    constructor(...how) { super(...how); window.isSilent = false; window.made = (window.made ?? 0) + 1; }
    postMessage(message, ...more) {
      if (window.isSilent && message.frame) message.frame.close();
      else super.postMessage(message, ...more);
    }
  };
"""
LABEL = "Overlay Test Camera (1234:0a12)"
WEBCAM = webcam(LABEL)
NO_PICTURE = """
  navigator.mediaDevices.getUserMedia = async () =>
    Object.assign(document.createElement("canvas"), { width: 1280, height: 720 }).captureStream(0);
"""
ADDRESS = "/ar/?virtual=1&k1=-0.3&error=0&rate=5&hand=quick"
ESTIMATED = re.compile(r"up to ([\d.]+)\spx\. Estimated \d+° \((\d+)° to (\d+)°\), calibrated (\d+)°")
READ = page_function("ar")
DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
PARAMETERS = cv2.aruco.CharucoParameters()
PARAMETERS.minMarkers = 1  # at the picture's corner there is no second one
DETECTOR = cv2.aruco.CharucoDetector(cv2.aruco.CharucoBoard((9, 6), 1.0, 0.65, DICTIONARY), PARAMETERS)
CORNERS = (0, 7, 32, 39)  # the outermost, which have marks
COLUMNS = 8
OUTER = {0, 1, 6, 7}  # columns where no house stands
AT_THE_CORNER = 0.14  # diagonals; nearer, every marker is cut off
WINDOW = 8  # px; half that of a corner's surroundings
ARM = 14  # px; of a crossing's: lines are up to 9 px wide


def seen(picture: npt.NDArray[np.uint8]) -> dict[int, Array]:
    """Find the board's corners: id → px."""
    grey = cv2.cvtColor(picture[..., :3], cv2.COLOR_BGR2GRAY)
    points, ids, _, _ = DETECTOR.detectBoard(grey)
    return dict(zip(ids.ravel().tolist(), refined(grey, points.reshape(-1, 2), WINDOW), strict=True))


def refined(grey: npt.NDArray[np.uint8], points: Array, half: int) -> Array:
    criteria = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 50, 1e-4)
    start = points.astype(np.float32).reshape(-1, 1, 2)
    return np.asarray(cv2.cornerSubPix(grey, start, (half, half), (-1, -1), criteria)).reshape(-1, 2)


def crossings(colour: npt.NDArray[np.uint8], near: Array) -> Array:
    """Find where lines cross: on a softer picture, since a wide line's edges are not its middle."""
    return refined(cv2.GaussianBlur(colour, (0, 0), 1.5), near, ARM)


def marks(overlay: npt.NDArray[np.uint8]) -> Array:
    """Find the blue crosses, which are bluer than the house: their middles, px."""
    blue, _, red, alpha = (overlay[..., channel].astype(float) for channel in range(4))
    blueness = np.round(np.clip(blue - red, 0, None) * alpha / 255).astype(np.uint8)
    count, _, boxes, middles = cv2.connectedComponentsWithStats((blueness > 200).astype(np.uint8))
    whole = [n for n in range(1, count) if boxes[n][cv2.CC_STAT_AREA] > 100]
    return crossings(blueness, middles[whole])


def at_the_corner(look: dict[str, Any]) -> tuple[float, float]:
    """Misalignment of the mark nearest to the image's corner, px; its distance from the corner, diagonals."""
    picture, overlay = decoded(look["picture"]), decoded(look["overlay"])
    h, w = picture.shape[:2]
    assert overlay.shape[:2] == (h, w)
    assert look["picture"]["place"] == look["overlay"]["place"]
    corners, drawn = seen(picture), marks(overlay)
    assert 1 <= len(drawn) <= 4
    away = {
        index: float(np.hypot(min(u, w - 1 - u), min(v, h - 1 - v)))
        for index, (u, v) in corners.items()
        if index in CORNERS
    }
    nearest = min(away, key=lambda index: away[index])
    misalignment = np.linalg.norm(drawn - corners[nearest], axis=1).min()
    return float(misalignment), away[nearest] / float(np.hypot(w, h))


def over_the_grid(look: dict[str, Any]) -> Array:
    """Give the misalignment of the drawn grid's crossings beside the house, px."""
    corners = seen(decoded(look["picture"]))
    places = np.array(
        [place for index, place in corners.items() if index % COLUMNS in OUTER and index not in CORNERS]
    )
    overlay = decoded(look["overlay"]).astype(float)
    red = np.round(overlay[..., 2] * overlay[..., 3] / 255).astype(np.uint8)
    return np.linalg.norm(crossings(red, places) - places, axis=1)


def check(looks: dict[str, Any]) -> None:
    off = {name: at_the_corner(look) for name, look in looks.items()}
    grid = {name: over_the_grid(look) for name, look in looks.items() if name != "matrix"}
    for name, (distance, away) in off.items():
        print(f"{name}: {distance:.3f} px off, {away:.3f} diagonals from the corner; {looks[name]['said']}")
    for name, errors in grid.items():
        rms = np.sqrt((errors**2).mean())
        print(f"{name}: {len(errors)} crossings, {rms:.3f} px rms, {errors.max():.3f} at most")
    assert all(away < AT_THE_CORNER for _, away in off.values())
    assert off["matrix"][0] > 8
    for name in ("rectified", "whole", "distorted"):
        assert off[name][0] < 0.5, name
        assert len(grid[name]) >= 8
        assert grid[name].max() < 0.5, name


@pytest.mark.thorough
def test_overlays_fit_in_firefox(stack: str, in_firefox: InFirefox) -> None:
    check(in_firefox(f"{stack}{ADDRESS}", READ))


def test_overlays_fit_in_a_practice_that_only_requests_an_estimate(page: Page) -> None:
    sent: list[Request] = []
    page.on("request", lambda request: None if request.method == "GET" else sent.append(request))
    page.add_init_script(SILENCED)
    page.goto(f"{ADDRESS.replace('virtual=1&', '')}&img_size=640x360")
    page.locator("#welcome .virtually").click()
    page.locator("#rms:not(:empty)").wait_for()
    expect(page.locator("#facts")).to_contain_text("exact, because the camera is simulated")
    there = urlsplit(page.locator("#recalibrate").evaluate("link => link.href"))
    query = parse_qs(there.query)
    assert (there.path, query["k1"]) == ("/calibrate/", ["-0.3"])
    assert urlsplit(query["return_to"][0]).path == "/ar/"
    check(page.evaluate(READ))
    for key, name in (("1", "matrix"), ("2", "rectified"), ("3", "distorted")):
        page.keyboard.press(key)
        page.locator(f"#stage[data-shown={name}]").wait_for()
    page.keyboard.press("m")
    said = page.locator("#outermost")
    expect(said).to_contain_text("outermost corner")
    page.evaluate("[window.made, window.isSilent] = [0, true]")
    until(page, lambda: page.evaluate("window.made") == 1)
    expect(said).to_contain_text("outermost corner")
    assert sent == []
    page.get_by_role("button", name="Use the estimate").click()
    page.locator("#stage[data-shown=estimate]").wait_for()
    expect(said).to_contain_text(ESTIMATED)
    assert [urlsplit(request.url).path for request in sent] == ["/v1/lookup"]
    off = float((page.locator("#rms").text_content() or "").split()[0])
    numbers = ESTIMATED.search(said.inner_text())
    assert numbers
    largest, low, high, calibrated = map(float, numbers.groups())
    print(f"estimate: {off} px rms, {largest} at most; {low} to {high}°, calibrated {calibrated}°")
    assert 1 < off < largest < 200, "the estimate knows nothing of the distortion"
    assert low < calibrated < high
    picture(page, "ar-estimate", ["hand"])
    page.keyboard.press("3")
    page.locator("#stage[data-shown=distorted]").wait_for()
    expect(said).to_contain_text("at the outermost corner")
    page.get_by_role("button", name="Stop").click()
    page.locator("#welcome-title:focus").wait_for()
    expect(page.locator(".virtual-camera:not(video)")).to_have_count(0)


@pytest.mark.thorough
def test_without_the_service_there_is_no_estimate(page: Page) -> None:
    page.route("**/v1/lookup", lambda route: route.fulfill(status=503, json={}))
    page.goto(ADDRESS)
    page.locator("#rms:not(:empty)").wait_for()
    page.get_by_role("button", name="Use the estimate").click()
    expect(page.locator("#outermost")).not_to_contain_text("outermost corner", timeout=30_000)
    expect(page.locator("#stage")).to_have_attribute("data-shown", "matrix")


def test_a_camera_that_nobody_knows_is_sent_to_be_calibrated(context: BrowserContext) -> None:
    page = context.new_page()
    sent: list[Request] = []
    page.on("request", lambda request: sent.append(request))
    page.add_init_script(WEBCAM + BLIND_DETECTOR)
    page.goto("/de/ar/")
    page.locator("#start").click()
    page.locator("#unknown:not([hidden])").wait_for()
    assert f"{LABEL}, 1280 × 720" in (page.locator("#unknown-text").text_content() or "")
    there = parse_qs(urlsplit(page.locator("#calibrate").evaluate("link => link.href")).query)
    assert there["camera"] == [LABEL]
    assert urlsplit(there["return_to"][0]).path == "/de/ar/"
    picture(page, "ar-unknown", ["hand"])
    [request] = [request for request in sent if request.method != "GET"]
    assert set(request.post_data_json) <= {
        "camera", "platform", "img_size", "zoom", "distortion_model", "redirect", "miss",
    }  # fmt: skip


def test_requested_camera_is_opened_from_a_late_list_and_reopened(page: Page) -> None:
    answer(page, "**/v1/lookup", known)
    page.add_init_script(PLUGGED + LISTED_LATE + BLIND_DETECTOR)
    page.goto("/ar/?camera=HD+Pro+Webcam+C920+(046d:082d)&lang=en")
    page.locator("#start").click()
    page.evaluate("window.answer()")
    page.locator("#instruction:not(:empty)").wait_for()
    assert page.evaluate("window.asked.deviceId") == {"exact": "0"}
    expect(page.locator("#facts")).to_contain_text("from calibDB")
    expect(page.locator("#move")).to_be_hidden()
    page.evaluate(PLUG, False)
    page.evaluate(UNPLUG)
    page.locator("#failure", has_text="this page continues automatically").wait_for()
    page.evaluate("window.asked = null")
    page.evaluate(PLUG, True)
    page.locator("#instruction:not(:empty)").wait_for()
    assert page.evaluate("window.asked.deviceId") == {"exact": "0"}


@pytest.mark.parametrize(
    ("address", "where"),
    [("/examples/three/", "#problem"), *thorough(("/ar/", "#failure"), ("/calibrate/", "#failure"))],
)
def test_without_a_picture_it_is_said_to_send_none(page: Page, address: str, where: str) -> None:
    page.clock.install()
    page.add_init_script(WEBCAM + NO_PICTURE + BLIND_DETECTOR)
    page.goto(address)
    page.locator("#start").click()

    def said() -> bool:
        page.clock.run_for(5_000)
        return "The camera is open but sends no picture." in (page.locator(where).text_content() or "")

    until(page, said)


def test_a_link_to_a_result_is_followed_unless_it_is_gone(context: BrowserContext) -> None:
    page = context.new_page()
    page.add_init_script(WEBCAM + BLIND_DETECTOR)
    answer(page, "**/v1/lookup", known)
    page.route(
        "**/v1/calibrations/gone", lambda route: route.fulfill(status=410, json={"detail": "withdrawn"})
    )
    page.route("**/v1/calibrations/here", lambda route: route.fulfill(json=result()))
    for link, origin in (("gone", "from calibDB"), ("here", "measured just now")):
        page.goto(PLAIN)
        page.goto(f"/ar/#calibration={link}")
        page.locator("#facts", has_text=origin).wait_for()
