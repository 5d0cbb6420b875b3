"""A camera that the service knows, and functions that look at sessions of WebXR in a page."""

import json
from pathlib import Path
from typing import Any

import httpx

from . import captures
from .truth import Truth

LABEL = "WebXR Test Camera (1234:0a0b)"
KEY = {"camera": LABEL, "platform": "X11; Linux x86_64", "img_size": [1280, 720], "zoom": 0}
TRUTH = Truth()
SHARED = Path(__file__).with_name("webxr.js").read_text()


def script(body: str, **constants: object) -> str:
    """A function to run in a page."""
    given = "".join(f"const {name} = {json.dumps(value)};" for name, value in constants.items())
    return f"async () => {{ {given} {SHARED} {body} }}"


def calibrated(api: httpx.Client, model: str = "rectilinear") -> dict[str, Any]:
    """Answer of a lookup of the camera; the first call calibrates it five times."""
    wanted = KEY | {"distortion_model": model, "redirect": False}
    answer = api.post("/lookup", json=wanted)
    if answer.status_code != 200:
        captures.calibrated(api, TRUTH, KEY)
    return captures.agreed(api, KEY, model)
