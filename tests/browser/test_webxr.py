"""WebXR on a webcam, and an unchanged application of three.js on it."""

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from playwright.sync_api import BrowserContext, Page, Route, ViewportSize

from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.pictures import shot
from tests.helpers.browser.scripts import FOLDER, PLAIN
from tests.helpers.browser.truth import SMALL, Truth
from tests.helpers.browser.waiting import until
from tests.helpers.browser.webxr import LABEL, attributes, known_camera, script

from .conftest import ROOT

Array = npt.NDArray[np.float64]

SESSIONS = (FOLDER / "webxr_sessions.js").read_text()
#: matrix and distortion of `known` in webxr.js
MATRIX = [500, 0, 0, 0, 505, 0, 325, 178, 1]
COEFFICIENTS = [-0.25, 0.0625, 0, 0, 0]
THREE = ROOT / "node_modules/three"
FOLDERS = ("build", "examples/jsm/webxr")
FILES = {file.name: file for folder in FOLDERS for file in THREE.glob(f"{folder}/*.js")}
APPLICATION = (FOLDER / "webxr_three.js").read_text()
#: camera frame, x right, y down, z forward; the second is near a corner of the picture
POINTS = np.array([[0.0, 0.0, 4.0], [-2.2, 0.85, 4.0], [1.2, -0.6, 3.0]])
WINDOW = ViewportSize(width=960, height=600)
GREEN, RED = 1, 2


def held(name: str) -> str:
    return script(f"{SESSIONS} return sessions.{name}();", label=LABEL)


def check_nothing(said: dict[str, Any]) -> None:
    assert (said["matrix"], said["coefficients"], said["model"]) == (None, None, None)


def check_answered(said: dict[str, Any], answer: dict[str, Any]) -> None:
    assert [said["matrix"], said["coefficients"], said["model"]] == attributes(answer)


def projection(window: list[float]) -> list[float]:
    """P0, P5, P8, P9 of the calibration `known`, its picture laid over all of a window."""
    w, h = window
    scale = max(w / 640, h / 360)
    return [
        2 * scale * 500 / w,
        2 * scale * 505 / h,
        -(2 * scale * (325 + 0.5 - 320)) / w,
        (2 * scale * (178 + 0.5 - 180)) / h,
    ]


def check_immersive(seen: dict[str, Any]) -> None:
    assert seen["needed"] is True
    assert seen["supported"] is True
    assert seen["twice"] == "InvalidStateError"
    check_nothing(seen["none"])
    assert seen["none"]["views"] == 1
    first, second = seen["first"], seen["second"]
    assert (first["matrix"], first["coefficients"]) == (MATRIX, COEFFICIENTS)
    assert second["matrix"] == [490, 0, 0, 0, 495, 0, 324, 177, 1]
    assert (second["coefficients"], second["model"]) == ([-0.125, 0.5, 0, 0.25], "fisheye")
    assert seen["window"] == [1440, 900]
    p = first["p"]
    assert [p[0], p[5], p[8], p[9]] == pytest.approx(projection(seen["window"]), abs=1e-6)
    assert (seen["over"], seen["back"]) == (True, True)


def test_augmented_reality_on_a_webcam(page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    page.goto(PLAIN)
    check_immersive(page.evaluate(held("immersive")))


@pytest.mark.thorough
def test_augmented_reality_on_a_webcam_in_firefox(stack: str, in_firefox: InFirefox) -> None:
    check_immersive(in_firefox(f"{stack}{PLAIN}", held("immersive"), size=(1440, 900)))


def test_a_turned_camera_is_looked_up_again_and_loses_its_matrix(context: BrowserContext) -> None:
    page = context.new_page()
    known = known_camera(page)

    def refuse_other_sizes(route: Route) -> None:
        asked = route.request.post_data_json
        assert asked["camera"] == LABEL
        if asked["img_size"] == known["img_size"]:
            return route.fallback()
        missing = {"reason": "other_size", "guidance_url": "/calibrate/", "detail": "None."}
        return route.fulfill(status=404, json=missing)

    page.route("**/v1/lookup", refuse_other_sizes)
    page.goto(PLAIN)
    found = page.evaluate(held("changing"))
    first, turned, again = found["seen"]
    check_answered(first, known)
    check_nothing(turned)
    check_answered(again, known)
    assert [each if isinstance(each, str) else tuple(each) for each in found["answers"]] == [
        (1280, 720),
        "other_size",
        (1280, 720),
    ]
    check_nothing(found["open"])


def serve(route: Route) -> None:
    route.fulfill(path=FILES[route.request.url.rsplit("/", 1)[1]], content_type="text/javascript")


def middles(picture: npt.NDArray[np.uint8], channel: int) -> Array:
    """Centres of the blobs of one colour, (n, 2) px from the window's corner, from left to right."""
    others = [each for each in range(3) if each != channel]
    pure = np.clip(picture[..., channel].astype(int) - picture[..., others].max(axis=2), 0, 255)
    count, labels = cv2.connectedComponents((pure > 40).astype(np.uint8))
    found = []
    for n in range(1, count):
        v, u = np.nonzero(labels == n)
        found.append(np.average(np.stack([u, v], axis=1) + 0.5, axis=0, weights=pure[v, u]))
    return np.array(sorted(found, key=lambda place: place[0]))


def test_a_scene_lies_on_the_straightened_picture(page: Page) -> None:
    known = known_camera(page) | {"img_size": SMALL.size, "camera_matrix": SMALL.matrix.tolist()}
    page.route("**/v1/lookup", lambda route: route.fulfill(json=known))
    distortion = np.array(known["distortion_coefficients"])
    marks = cv2.projectPoints(POINTS, np.zeros(3), np.zeros(3), SMALL.matrix, distortion)[0].reshape(-1, 2)
    bent = np.linalg.norm(marks - (POINTS @ SMALL.matrix.T)[:, :2] / POINTS[:, 2:], axis=1)
    assert bent.max() > 30 * SMALL.size[0] / Truth.size[0]
    page.set_viewport_size(WINDOW)
    page.route("**/three/*.js", serve)
    page.goto(PLAIN)
    constants = {"label": LABEL, "points": POINTS.tolist(), "marks": marks.tolist()}
    page.evaluate(script(f"{APPLICATION} await run();", **constants))

    def seen() -> tuple[Array, Array] | None:
        picture = shot(page)
        green, red = middles(picture, GREEN), middles(picture, RED)
        return (green, red) if len(green) == len(red) == len(POINTS) else None

    found = until(page, seen)  # camera and scene have rates of their own
    assert found is not None
    green, red = found
    assert np.linalg.norm(green - red, axis=1).max() < WINDOW["width"] / 1440, "a pixel of a wide window"
    page.locator("svg:visible").last.click()
    page.evaluate("over")
    assert page.locator("video").evaluate("(video) => video.parentNode === document.body")
