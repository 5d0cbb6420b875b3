"""Answers of the service as pages get them, for states that would take long to reach."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Page, Route

from ...browser.conftest import ROOT

CAMERAS = [
    ("HD Pro Webcam C920 (046d:082d)", "X11; Linux x86_64"),
    ("Integrated Camera (04f2:b6d9)", "Windows NT 10.0; Win64; x64"),
    ("camera2 0, facing back", "Linux; Android 14; Pixel 7"),
    ("GoPro HERO9 Black", "photographs"),
    ("FaceTime HD Camera", "Macintosh; Intel Mac OS X 10_15_7"),
    ("calibDB virtual camera 8b0a5c1f", "X11; Linux x86_64"),
]


def result() -> dict[str, Any]:
    """A calibration with its report: one view left out, of one much is, one stands out."""
    found: dict[str, Any] = json.loads((ROOT / "tests" / "web" / "result.json").read_text())
    board = {"squares": [9, 6], "marker_ratio": 0.65, "dictionary": "DICT_4X4_50", "legacy": False}
    return found | {"board": board, "camera_key": None}


def rig() -> dict[str, Any]:
    """State of a finished rig of two simulated cameras whose board is bent."""
    state: dict[str, Any] = json.loads((ROOT / "tests" / "web" / "rig_state.json").read_text())
    return state


def result_of_camera() -> dict[str, Any]:
    """The same, of a camera whose page there is: `camera`."""
    return result() | {"camera_key": "c2.specimen"}


def camera() -> dict[str, Any]:
    """One camera: a size that is known, where two calibrations do not agree, and one that is not."""
    rng = random.Random(3)
    agreed = result() | {
        "calibrations": 9,
        "contributors": 6,
        "reliable": True,
        "id": "c~1280x720~0~rectilinear",
    }
    for name in ("report", "board", "camera_key"):
        del agreed[name]
    members = [
        {
            "id": f"m{index}",
            "time": 1_767_225_600 + index * 86_400 * 9,
            "fx": 977 + rng.gauss(0, 4) + (120 if index in {3, 8} else 0),
            "fy": 979 + rng.gauss(0, 4),
            "cx": 657 + rng.gauss(0, 5),
            "cy": 351 + rng.gauss(0, 5),
            "rms": 0.2,
            "model": "rectilinear",
            "in_group": index not in {3, 8},
        }
        for index in range(11)
    ]
    groups = [[f"m{index}" for index in range(11) if index not in {3, 8}], ["m3", "m8"]]
    known = {
        "img_size": [1280, 720],
        "zoom": 0,
        "calibrations": 11,
        "contributors": 7,
        "agreeing": 9,
        "required": 5,
        "reason": None,
        "groups": groups,
        "consensus": {"rectilinear": agreed},
        "members": members,
    }
    unknown = known | {
        "img_size": [640, 480],
        "zoom": 1.5,
        "calibrations": 2,
        "contributors": 2,
        "agreeing": 2,
        "reason": "too_few",
        "groups": [["m0", "m1"]],
        "consensus": {},
        "members": members[:2],
    }
    name, platform = CAMERAS[0]
    usb = {"usb_id": "046d:082d", "vendor": "Logitech, Inc."}
    return {"key": "c2.specimen", "camera": name, "platform": platform, **usb, "modes": [known, unknown]}


def cameras() -> dict[str, Any]:
    """Some cameras, and more of them."""
    sizes = [
        {
            "img_size": size,
            "zoom": 0,
            "models": ["rectilinear"],
            "calibrations": 6,
            "contributors": 4,
            "agreeing": agreeing,
            "required": 5,
            "fx": 977.0,
            "uncertainty": 0.042 * (6 - agreeing),
            "calibration_time": 1_767_225_600,
        }
        for size, agreeing in (([1280, 720], 5), ([640, 480], 2))
    ]
    found = [
        {
            "key": f"c2.{index}",
            "camera": name,
            "platform": platform,
            "usb_id": None,
            "vendor": None,
            "sizes": [size | {"reliable": index < 2 and at == 0} for at, size in enumerate(sizes)],
        }
        for index, (name, platform) in enumerate(CAMERAS)
    ]
    return {"cameras": found, "next": "more"}


def answer(page: Page, pattern: str, body: Callable[[], dict[str, Any]]) -> None:
    """Answer requests of a page by a specimen. A lookup is answered by no cache."""
    if pattern.endswith("/v1/lookup"):
        miss = {"reason": "unknown_camera"}
        page.route("**/known/v1/**", lambda route: route.fulfill(status=404, json=miss))

    def fulfil(route: Route) -> None:
        route.fulfill(json=body())

    page.route(pattern, fulfil)
