"""A known camera, and functions that inspect sessions of WebXR in a page."""

import json
from typing import Any

import numpy as np
from playwright.sync_api import Page, Route

from . import specimens
from .scripts import FOLDER
from .truth import Truth

LABEL = "WebXR Test Camera (1234:0a0b)"
TRUTH = Truth()
SHARED = (FOLDER / "webxr.js").read_text()


def attributes(calibration: dict[str, Any]) -> list[Any]:
    """Matrix, coefficients and model of a view of a camera, in floats of 32 bits."""
    matrix = np.array(calibration["camera_matrix"]).T.ravel().astype(np.float32)
    coefficients = np.array(calibration["distortion_coefficients"]).astype(np.float32)
    return [matrix.tolist(), coefficients.tolist(), calibration["distortion_model"]]


def script(body: str, **constants: object) -> str:
    given = "".join(f"const {name} = {json.dumps(value)};" for name, value in constants.items())
    return f"async () => {{ {given} {SHARED} {body} }}"


def known_camera(page: Page) -> dict[str, Any]:
    """Answer lookups of a page with a calibration of either model; return the rectilinear one."""
    lens = {"camera_matrix": TRUTH.matrix.tolist(), "distortion_coefficients": TRUTH.distortion.tolist()}
    known = specimens.known() | lens
    fisheye = known | {"distortion_model": "fisheye", "distortion_coefficients": [0.01, 0, 0, 0]}

    def fulfil(route: Route) -> None:
        route.fulfill(json=fisheye if "fisheye" in (route.request.post_data or "") else known)

    page.route("**/known/v1/**", lambda route: route.fulfill(status=404, json={"reason": "unknown_camera"}))
    page.route("**/v1/lookup", fulfil)
    return known
