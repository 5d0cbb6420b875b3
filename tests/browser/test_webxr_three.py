"""An application of three.js, unchanged, on a webcam."""

import cv2
import numpy as np
import numpy.typing as npt
from playwright.sync_api import Page, Route, ViewportSize

from tests.helpers.browser.pictures import shot
from tests.helpers.browser.scripts import FOLDER, PLAIN
from tests.helpers.browser.truth import SMALL, Truth
from tests.helpers.browser.waiting import until
from tests.helpers.browser.webxr import LABEL, known_camera, script

from .conftest import ROOT

Array = npt.NDArray[np.float64]

THREE = ROOT / "node_modules/three"
FOLDERS = ("build", "examples/jsm/webxr")
FILES = {file.name: file for folder in FOLDERS for file in THREE.glob(f"{folder}/*.js")}
APPLICATION = (FOLDER / "webxr_three.js").read_text()
#: camera frame, x right, y down, z forward; the second is near a corner of the picture
POINTS = np.array([[0.0, 0.0, 4.0], [-2.2, 0.85, 4.0], [1.2, -0.6, 3.0]])
WINDOW = ViewportSize(width=960, height=600)
GREEN, RED = 1, 2


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
