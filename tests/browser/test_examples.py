"""Examples of other engines."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import httpx
import numpy as np
import numpy.typing as npt
import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.helpers.browser.captures import capture
from tests.helpers.browser.pictures import picture, shot
from tests.helpers.browser.scenes import webcam
from tests.helpers.browser.specimens import answer
from tests.helpers.browser.truth import SMALL
from tests.helpers.browser.waiting import until

from ..conftest import THOROUGH
from .test_ar import DICTIONARY, LABEL

Array = npt.NDArray[np.float64]
TRUTH = replace(SMALL, k1=-0.2)
SQUARES = (9, 6)
DEPTH = 1.6 * SQUARES[0] * TRUTH.fx / TRUTH.size[0]
MARKS = np.array([(-4.5, -3), (4.5, -3), (4.5, 3), (-4.5, 3)])
CORNERS = np.array([(x - 4.5, y - 3.0) for y in range(1, 6) for x in range(1, 9)])
AMBER = np.array([0, 176, 255])
STRAIGHT = """async (lens) => {
  const { rectifiedMatrix } = await import("/sdk/rectification.js");
  return rectifiedMatrix(lens, 0);
}"""
PLACE = """() => {
  const { left, top, width, height } = document.querySelector("#stage").getBoundingClientRect();
  return [width, height, left - Math.floor(left), top - Math.floor(top)];
}"""
NO_CAMERA = 'throw new DOMException("none", "NotFoundError");'
RATIOS = ("16 / 9", "4 / 3", "2 / 1")  # the last two cut the picture, at its sides and above and below
RESIZED = """async (ratio) => {
  document.querySelector("#stage").style.aspectRatio = ratio;
  for (let frame = 0; frame < 5; frame++) await new Promise(requestAnimationFrame);
}"""
SMALL_WEBCAM = webcam(LABEL, size=SMALL.size)
#: keeps what the page was given in sight
GIVEN = f"""{SMALL_WEBCAM}
  window.given = [];
  const give = navigator.mediaDevices.getUserMedia;
  navigator.mediaDevices.getUserMedia = async () => {{
    const stream = await give();
    window.given.push(...stream.getTracks());
    return stream;
  }};
"""
DETECTOR = cv2.aruco.CharucoDetector(cv2.aruco.CharucoBoard(SQUARES, 1.0, 0.65, DICTIONARY))


def amber(image: npt.NDArray[np.uint8]) -> Array:
    """Return the middles of the marks, (n, 2) px from the picture's corner."""
    mask = (np.abs(image.astype(int) - AMBER).max(axis=2) < 60).astype(np.uint8)
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((5, 5)))  # the box's lines cross them
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    hulls = [cv2.moments(cv2.convexHull(o)) for o in outlines if cv2.contourArea(o) > 30]
    return np.array([(m["m10"] / m["m00"] + 0.5, m["m01"] / m["m00"] + 0.5) for m in hulls])


def complete(page: Page) -> tuple[npt.NDArray[np.uint8], Array, Array]:
    """Wait for picture and scene; return both, the marks, and the board's corners, px."""

    def seen() -> tuple[npt.NDArray[np.uint8], Array, Array] | None:
        image = shot(page.locator("#stage"))
        marks = amber(image)
        corners, ids, _, _ = DETECTOR.detectBoard(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY))
        whole = len(marks) == len(MARKS) and ids is not None and len(ids) > 12
        return (image, marks, corners.reshape(-1, 2) + 0.5) if whole else None

    found = until(page, seen)
    assert found is not None
    return found


def expected(matrix: Any, plane: Array, depth: float, viewport: tuple[int, int]) -> Array:
    """Positions of a pinhole's points in a viewport that its picture covers, px from the corner."""
    (fx, _, cx), (_, fy, cy), _ = matrix
    size = np.array(TRUTH.size)
    scale = max(np.array(viewport) / size)
    pixels = plane / depth * (fx, fy) + (cx, cy)
    return np.asarray((pixels + 0.5 - size / 2) * scale + np.array(viewport) / 2)


def distance(found: Array, wanted: Array) -> float:
    """Largest distance of a point of `found` to the nearest of `wanted`, px."""
    return float(np.linalg.norm(found[:, None] - wanted[None], axis=2).min(axis=1).max())


@pytest.mark.parametrize(
    "engine", ["three", *(pytest.param(each, marks=pytest.mark.thorough) for each in ("babylon", "aframe"))]
)
def test_a_scene_lies_on_the_picture(page: Page, engine: str) -> None:
    page.goto(f"/examples/{engine}/?{TRUTH.query(error=0)}&still=1")
    lens = {"img_size": TRUTH.size, "camera_matrix": TRUTH.matrix.tolist(), "distortion_model": "rectilinear"}
    matrix = page.evaluate(STRAIGHT, lens | {"distortion_coefficients": TRUTH.distortion.tolist()})
    for ratio in RATIOS if THOROUGH else RATIOS[-1:]:
        page.evaluate(RESIZED, ratio)
        image, marks, seen = complete(page)
        # A stage that begins between two pixels: its screenshot begins at the first.
        width, height, *begin = page.evaluate(PLACE)
        viewport = (width, height)
        assert max(abs(image.shape[1] - width), abs(image.shape[0] - height)) <= 2
        marks, seen = marks - begin, seen - begin
        wanted = expected(matrix, MARKS, DEPTH, viewport)
        assert len(marks) == len(MARKS), ratio
        assert distance(marks, wanted) < 1, (ratio, marks, wanted)
        assert distance(seen, expected(matrix, CORNERS, DEPTH, viewport)) < 1
    if THOROUGH:
        page.locator("#calibrated").uncheck()
        _, _, seen = complete(page)
        bent = distance(seen - begin, expected(matrix, CORNERS, DEPTH, viewport))
        assert bent > 3, "the picture is not straightened"
        page.locator("#calibrated").check()
        page.evaluate(RESIZED, "")
        picture(page, f"example-{engine}", ["hand"], full=True)


def test_a_refused_camera_is_released_an_unknown_one_estimated(
    context: BrowserContext,
) -> None:
    page = context.new_page()
    page.add_init_script(GIVEN)
    page.route("**/v1/lookup", lambda route: route.fulfill(status=403, json={"detail": "no"}), times=1)
    page.goto("/examples/three/")
    page.locator("#start").dblclick()
    page.locator("#problem:not(:empty)").wait_for()
    assert page.evaluate("window.given.map((track) => track.readyState)") == ["ended"]
    expect(page.locator("#stage")).to_be_hidden()
    page.locator("#start").click()
    link = page.locator("#problem a", has_text="Calibrate")
    link.wait_for()
    expect(page.locator("#problem")).to_contain_text("drawn with an estimate, ±")
    assert "return_to=" in (link.get_attribute("href") or "")
    expect(page.locator("#stage")).to_be_visible()
    assert page.evaluate("window.given.map((track) => track.readyState)") == ["ended", "live"]


def test_depth_of_a_rectified_pair_is_the_boards(page: Page) -> None:
    page.goto("/examples/stereo/")
    depth = page.locator("#depth")
    expect(depth).to_contain_text("squares away")
    for column, row in ((250, 200), (400, 300)):
        page.locator("#row").fill(str(row))
        page.locator("#column").fill(str(column))
        expect(depth).to_contain_text("squares away")
        disparity, measured, truth = map(float, re.findall(r"\d+\.\d+", depth.inner_text()))
        assert abs(measured / truth - 1) < 1 / disparity, "within a pixel of disparity"
    page.locator("#column").fill("600")
    page.locator("#row").fill("20")
    expect(depth).to_contain_text("Nothing here stands out")
    picture(page, "example-stereo", ["hand"], full=True)
    page.locator("#rectified").click()
    expect(depth).to_contain_text("as the cameras deliver them")


def test_the_page_for_ar_js_gives_the_cameras_own_file(page: Page, api: httpx.Client) -> None:
    key = {"camera": "AR.js Test Camera (1234:0007)", "platform": "X11; Linux x86_64", "img_size": SMALL.size}
    measured = capture(api, SMALL, key, seed=11)["calibration_id"]
    stored = api.get(f"/calibrations/{measured}").json()
    answer(page, "**/v1/lookup", lambda: stored | {"calibrations": 5, "reliable": True, "exact_size": True})
    page.add_init_script(SMALL_WEBCAM)
    page.goto("/examples/arjs/")
    page.locator("#start").click()
    page.locator("#ready").wait_for()
    with page.expect_download() as download:
        page.locator("#file").click()
    assert download.value.suggested_filename == "camera_para.dat"
    assert Path(download.value.path()).stat().st_size == 176
    assert page.locator("#error").text_content()
    picture(page, "example-arjs", ["hand"], full=True, check=THOROUGH)


def test_gallery_of_examples_without_a_camera(page: Page) -> None:
    page.add_init_script(f"navigator.mediaDevices.getUserMedia = async () => {{ {NO_CAMERA} }}")
    page.goto("/examples/")
    expect(page.locator(".gallery a")).to_have_count(6)
    page.locator(".gallery a", has_text="AR.js").click()
    expect(page.locator("#virtually")).to_have_count(0)
    page.locator("#start").click()
    expect(page.locator("#problem")).to_have_text("No camera was found. Plug one in, then try again.")
