"""Guided captures over HTTP with synthetic views, where a browser would add nothing but time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import cv2
import httpx
import numpy as np

from tests.helpers.service.client import until

from .truth import Truth
from .waiting import TIMEOUT_S

BOARD = {"squares": [9, 6], "marker_ratio": 0.65, "dictionary": "DICT_4X4_50", "legacy": False}
POINTS = np.array([(x, y, 0.0) for y in range(1, 6) for x in range(1, 9)])
NOISE = 0.05  # px; what the page's detector has


@contextmanager
def begin(api: httpx.Client, **request: object) -> Iterator[httpx.Client]:
    """Start a session; give a client that speaks with its credential."""
    session_id = api.post("/auth").raise_for_status().json()["session_id"]
    headers = {"authorization": f"Bearer {session_id}"}
    with httpx.Client(base_url=api.base_url, headers=headers, timeout=60) as session:
        answer = session.post("/session", json=request)
        assert answer.status_code == 201, answer.text
        yield session


def capture(api: httpx.Client, truth: Truth, key: dict[str, Any], seed: int) -> dict[str, Any]:
    """Run one session to its end, holding the board as asked, a little off; return its last state."""
    rng = np.random.default_rng(seed)
    with begin(api, **key, board=BOARD) as session:
        for _ in range(20):
            pose = session.get("/session/pose", headers={"accept": "application/json"}).json()
            turn = np.array(pose["rvec"]) + rng.normal(0, 0.03, 3)
            place = np.array(pose["tvec"]) * (1 + rng.normal(0, 0.02, 3))
            seen = cv2.projectPoints(POINTS, turn, place, truth.matrix, truth.distortion)[0].reshape(-1, 2)
            seen += rng.normal(0, NOISE, seen.shape)
            w, h = truth.size
            inside = (seen > 4).all(axis=1) & (seen < (w - 5, h - 5)).all(axis=1)
            view = {
                "index": pose["index"],
                "ids": np.flatnonzero(inside).tolist(),
                "points": seen[inside].tolist(),
            }
            state: dict[str, Any] = session.post("/session/views", json=view).raise_for_status().json()
            if state["status"] == "converged":
                return state
    raise AssertionError(f"no convergence in 20 views: {state['uncertainty']}, {state['reason']}")


def agreed(api: httpx.Client, key: dict[str, Any], model: str = "rectilinear") -> dict[str, Any]:
    """Wait for what all calibrations of a camera agree on: it is computed apart from their requests."""
    wanted = key | {"distortion_model": model, "redirect": False}

    def found() -> dict[str, Any] | None:
        answer = api.post("/lookup", json=wanted)
        known: dict[str, Any] = answer.json()
        return known if answer.status_code == 200 else None

    known: dict[str, Any] = until(found, TIMEOUT_S)
    return known


def calibrated(api: httpx.Client, truth: Truth, key: dict[str, Any]) -> dict[str, Any]:
    """Calibrate a camera five times; return what the calibrations agree on."""
    for seed in range(5):
        capture(api, truth, key, seed)
    return agreed(api, key)


def listed(api: httpx.Client, words: str) -> None:
    """Wait until a camera of a name is listed with what is known of it: pages keep what they get."""

    def found() -> bool:
        cameras = api.get("/cameras", params={"query": words}).raise_for_status().json()["cameras"]
        return any(size["models"] for each in cameras for size in each["sizes"])

    until(found, TIMEOUT_S)
