"""Responses of the service for states that would take long to reach."""

import json
import re
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Page

from ...browser.conftest import ROOT
from ..vectors import recorded

VIRTUAL = "calibDB virtual camera 8b0a5c1f"


def _specimen(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((ROOT / "tests" / "browser" / "specimens.json").read_text())[name]
    return found


def result() -> dict[str, Any]:
    """A calibration with its report: one view excluded, one mostly, one worse than the others."""
    found: dict[str, Any] = json.loads((ROOT / "tests" / "web" / "result.json").read_text())
    board = {"squares": [9, 6], "marker_ratio": 0.65, "dictionary": "DICT_4X4_50", "legacy": False}
    return found | {"board": board, "camera_key": None}


def known() -> dict[str, Any]:
    """The response to a lookup of a known camera."""
    return result() | {"calibrations": 7, "reliable": True, "exact_size": True}


def rig() -> dict[str, Any]:
    """State of a finished rig of two simulated cameras whose board is bent."""
    state: dict[str, Any] = json.loads((ROOT / "tests" / "web" / "rig_state.json").read_text())
    return state


def rig_result() -> dict[str, Any]:
    """Result of a rig of two cameras, the first pair of the vectors."""
    pair = recorded("pairs")[0]
    still = {"position": 0, "rvec": [0, 0, 0], "tvec": [0, 0, 0], "std": [0] * 6}
    return {
        "rig_id": "1f0c7a3e5b2d49688c1e0f7d6a5b4c3d",
        "calibrations": [pair["left"] | {"camera": "C 1"}, pair["right"] | {"camera": "C 2"}],
        "extrinsics": [still, {"position": 1, **pair["pose"], "std": [0.001] * 6}],
        "unit": "metres",
        "uncertainty": {"rotation_deg": 0.05, "translation_percent": 0.2, "rms": 0.25},
        "verdict": {"level": "good", "reasons": []},
    }


def result_of_camera() -> dict[str, Any]:
    """The same, of `camera`."""
    return result() | {"camera_key": "c2.specimen"}


def camera() -> dict[str, Any]:
    """A camera with a known size, where two calibrations do not agree, and an unknown one."""
    names = {"report", "board", "camera_key"}
    agreed = {name: value for name, value in result().items() if name not in names}
    agreed |= {"calibrations": 9, "contributors": 6, "reliable": True, "id": "c~1280x720~0~rectilinear"}
    found = _specimen("camera")
    found["modes"][0]["consensus"] = {"rectilinear": agreed}
    return found


def cameras() -> dict[str, Any]:
    return _specimen("cameras")


def statistics() -> dict[str, Any]:
    return _specimen("statistics")


def dump() -> dict[str, Any]:
    return _specimen("dump")


# Answers in the page: routes take a third more time for every file, and turn off the cache.
_ANSWERING = """(([pattern, status, body]) => {
  const send = window.fetch;
  window.fetch = async (address, ...rest) => {
    const there = new URL(address instanceof Request ? address.url : address, location.href).href;
    return new RegExp(pattern).test(there) ? Response.json(body, { status }) : send(address, ...rest);
  };
})"""


def answer(page: Page, pattern: str, body: Callable[[], dict[str, Any]]) -> None:
    """Answer a page's requests by a specimen from its next navigation on; the last call takes precedence.

    `pattern` is an address in which `*` stands for a part and `**` for several. No cache answers a lookup.
    """
    if pattern.endswith("/v1/lookup"):
        _answer(page, "**/known/v1/**", 404, {"reason": "unknown_camera"})
    _answer(page, pattern, 200, body())


def _answer(page: Page, pattern: str, status: int, body: dict[str, Any]) -> None:
    parts = {"**": ".*", "*": "[^/]*"}
    expression = "".join(parts.get(part) or re.escape(part) for part in re.split(r"(\*+)", pattern))
    page.add_init_script(f"{_ANSWERING}({json.dumps([f'^{expression}$', status, body])})")
