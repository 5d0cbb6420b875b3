"""WebXR on a webcam."""

from typing import Any

import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, Route

from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.scripts import FOLDER, PLAIN
from tests.helpers.browser.webxr import LABEL, known_camera, script

SESSIONS = (FOLDER / "webxr_sessions.js").read_text()
#: matrix and distortion of `known` in webxr.js
MATRIX = [500, 0, 0, 0, 505, 0, 325, 178, 1]
COEFFICIENTS = [-0.25, 0.0625, 0, 0, 0]


def held(name: str) -> str:
    return script(f"{SESSIONS} return sessions.{name}();", label=LABEL)


def check_nothing(said: dict[str, Any]) -> None:
    assert (said["matrix"], said["coefficients"], said["model"]) == (None, None, None)


def check_answered(said: dict[str, Any], answer: dict[str, Any]) -> None:
    matrix = np.array(answer["camera_matrix"]).T.ravel().astype(np.float32)
    coefficients = np.array(answer["distortion_coefficients"]).astype(np.float32)
    assert (said["matrix"], said["coefficients"]) == (matrix.tolist(), coefficients.tolist())
    assert said["model"] == answer["distortion_model"]


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


@pytest.fixture
def asking(context: BrowserContext) -> Page:
    return context.new_page()


@pytest.fixture
def known(asking: Page) -> dict[str, Any]:
    known = known_camera(asking)

    def refuse_others(route: Route) -> None:
        asked = route.request.post_data_json
        is_size = asked["img_size"] == known["img_size"]
        if asked["camera"] == LABEL and is_size:
            return route.fallback()
        reason = "unknown_camera" if is_size else "other_size"
        missing = {"reason": reason, "guidance_url": "/calibrate/", "detail": "None."}
        return route.fulfill(status=404, json=missing)

    asking.route("**/v1/lookup", refuse_others)
    return known


def test_the_browsers_own_session_knows_its_camera(page: Page) -> None:
    page.goto(PLAIN)
    seen = page.evaluate(held("native"))
    assert seen["native"] is True
    assert (seen["first"]["matrix"], seen["first"]["coefficients"]) == (MATRIX, COEFFICIENTS)
    assert seen["second"]["coefficients"] == [-0.125, 0.5, 0, 0.25]


def test_augmented_reality_on_a_webcam(page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    page.goto(PLAIN)
    check_immersive(page.evaluate(held("immersive")))


@pytest.mark.thorough
def test_augmented_reality_on_a_webcam_in_firefox(stack: str, in_firefox: InFirefox) -> None:
    check_immersive(in_firefox(f"{stack}{PLAIN}", held("immersive"), size=(1440, 900)))


def test_a_turned_camera_is_looked_up_again_and_loses_its_matrix(asking: Page, known: dict[str, Any]) -> None:
    asking.goto(PLAIN)
    found = asking.evaluate(held("changing"))
    first, turned, again = found["seen"]
    check_answered(first, known)
    check_nothing(turned)
    check_answered(again, known)
    assert [each if isinstance(each, str) else tuple(each) for each in found["answers"]] == [
        (1280, 720),
        "other_size",
        (1280, 720),
    ]
    seen = asking.evaluate(held("turned"))
    check_answered(seen["before"], known)
    check_nothing(seen["after"])
