"""Guided captures over HTTP with synthetic views, where a browser would add nothing but time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import httpx

from tests.helpers.service import client as service
from tests.helpers.service.client import Client, until
from tests.helpers.service.remote import Remote

from .truth import Truth
from .waiting import TIMEOUT_S

NOISE = 0.05  # px; what the page's detector has


@contextmanager
def client(api: httpx.Client) -> Iterator[Client]:
    """Client of the server of `api`, in sessions of its own."""
    with Remote(str(api.base_url.copy_with(path="/"))) as remote:
        yield Client(remote)


def capture(api: httpx.Client, truth: Truth, key: dict[str, Any], seed: int) -> dict[str, Any]:
    """Run one session to its end, holding the board as asked, a little off; return its last state."""
    held = service.Truth(
        fx=truth.fx,
        fy=truth.fx,
        cx=truth.cx,
        cy=truth.cy,
        distortion=tuple(truth.distortion),
        img_size=truth.size,
        noise=NOISE,
        seed=seed,
    )
    with client(api) as capturing:
        state: dict[str, Any] = held.calibrate(capturing, 20, **key)
    return state


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
