"""WebXR that knows its camera: the browser's own, and on a webcam where that cannot augment reality."""

from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page

from tests.helpers.browser.firefox import InFirefox
from tests.helpers.browser.scripts import FOLDER, PLAIN
from tests.helpers.browser.webxr import LABEL, TRUTH, calibrated, script

SESSIONS = (FOLDER / "webxr_sessions.js").read_text()
#: matrix and distortion of `known` in webxr.js
MATRIX = [500, 0, 0, 0, 505, 0, 325, 178, 1]
COEFFICIENTS = [-0.25, 0.0625, 0, 0, 0]


def held(name: str) -> str:
    """Function that holds one of the sessions."""
    return script(f"{SESSIONS} return sessions.{name}();", label=LABEL)


def check_nothing(said: dict[str, Any]) -> None:
    assert (said["matrix"], said["coefficients"], said["model"]) == (None, None, None)


def check_answered(said: dict[str, Any], answer: dict[str, Any]) -> None:
    """A view says what the service does, in single precision and column by column."""
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


def test_the_browsers_own_inline_session(context: BrowserContext, api: httpx.Client) -> None:
    calibrated(api)
    page = context.new_page()  # which may complain: an unknown camera is a 404
    page.goto(PLAIN)
    seen = page.evaluate(held("native"))
    assert seen["native"] is True
    for nothing in seen["nothing"]:
        check_nothing(nothing)
        assert nothing["views"] == 1, "and frames come"
    assert seen["refused"] == "TypeError"
    check_answered(seen["first"], calibrated(api))
    check_answered(seen["second"], calibrated(api, "fisheye"))
    assert abs(seen["first"]["matrix"][0] / TRUTH.fx - 1) < 0.005
    assert seen["first"]["coefficients"][0] == pytest.approx(TRUTH.k1, abs=0.02)


def test_augmented_reality_on_a_webcam(page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    page.goto(PLAIN)
    check_immersive(page.evaluate(held("immersive")))


@pytest.mark.thorough
def test_augmented_reality_on_a_webcam_in_firefox(stack: str, in_firefox: InFirefox) -> None:
    check_immersive(in_firefox(f"{stack}{PLAIN}", held("immersive"), size=(1440, 900)))


def test_a_camera_that_is_turned_is_asked_for_again(context: BrowserContext, api: httpx.Client) -> None:
    known = calibrated(api)
    page = context.new_page()  # which may complain: what is unknown upright is a 404
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


def test_a_picture_that_is_turned_never_has_the_former_ones_matrix(page: Page, api: httpx.Client) -> None:
    known = calibrated(api)
    page.goto(PLAIN)
    seen = page.evaluate(held("turned"))
    check_answered(seen["before"], known)
    check_nothing(seen["after"])
