"""A known camera, and functions that inspect sessions of WebXR in a page."""

import json
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, Route

from .specimens import result
from .truth import Truth

LABEL = "WebXR Test Camera (1234:0a0b)"
TRUTH = Truth()
SHARED = Path(__file__).with_name("webxr.js").read_text()


def script(body: str, **constants: object) -> str:
    given = "".join(f"const {name} = {json.dumps(value)};" for name, value in constants.items())
    return f"async () => {{ {given} {SHARED} {body} }}"


def known_camera(page: Page) -> dict[str, Any]:
    """Answer lookups of a page with a calibration of either model; return the rectilinear one."""
    lens = {"camera_matrix": TRUTH.matrix.tolist(), "distortion_coefficients": TRUTH.distortion.tolist()}
    known = result() | lens | {"calibrations": 7, "reliable": True, "exact_size": True}
    fisheye = known | {"distortion_model": "fisheye", "distortion_coefficients": [0.01, 0, 0, 0]}

    def fulfil(route: Route) -> None:
        route.fulfill(json=fisheye if "fisheye" in (route.request.post_data or "") else known)

    page.route("**/known/v1/**", lambda route: route.fulfill(status=404, json={"reason": "unknown_camera"}))
    page.route("**/v1/lookup", fulfil)
    return known
