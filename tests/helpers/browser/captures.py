"""Calibrations of recorded synthetic views over HTTP, which take less time than guided captures."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import cv2
import httpx
import numpy as np

from tests.helpers.service import client as service
from tests.helpers.service.client import Client, until
from tests.helpers.service.remote import Remote

from .truth import Truth
from .waiting import TIMEOUT_S

NOISE = 0.05  # px; what the page's detector has
#: rotation of the board, degrees; its middle, from the image's middle, and its width, in parts of the image
HELD = (
    ((25, 10, 0), (0, 0), 0.9),
    ((-30, 25, 5), (-0.27, -0.2), 0.75),
    ((30, -25, -5), (0.27, 0.2), 0.75),
    ((-20, -35, 0), (0.27, -0.2), 0.75),
    ((35, 20, 10), (-0.27, 0.2), 0.75),
)


@contextmanager
def client(api: httpx.Client) -> Iterator[Client]:
    """Client of the server of `api`, in sessions of its own."""
    with Remote(str(api.base_url.copy_with(path="/"))) as remote:
        yield Client(remote)


def recorded(truth: service.Truth) -> Iterator[dict[str, Any]]:
    """Views of the board in the poses of `HELD`, as requests have them."""
    size, columns = np.array(truth.img_size), truth.squares[0]
    middle = np.append(np.array(truth.squares) / 2, 0)
    for tilt, aside, width in HELD:
        rotation = np.radians(np.array(tilt, dtype=float))
        depth = columns * truth.fx / (width * size[0])
        ahead = depth * np.append(np.array(aside) * size / truth.fx, 1)
        ids, points = truth.detect(rotation, ahead - cv2.Rodrigues(rotation)[0] @ middle)
        yield {"ids": ids, "points": points}


def capture(api: httpx.Client, truth: Truth, key: dict[str, Any], seed: int) -> dict[str, Any]:
    """Calibrate a camera from recorded views; return the last state of the session."""
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
    with client(api) as session:
        opened = session.open(**{"img_size": truth.size} | key, capture="recorded")
        assert opened.status == 201, opened.body
        views = list(recorded(held))
        sent = session.call("POST", "/v1/session/batch", {"index": 0, "views": views})
        assert sent.status == 200, sent.body
        state: dict[str, Any] = session.call("POST", "/v1/session/finish").json
    assert len(state["views"]) == len(HELD)
    assert state["status"] == "converged"
    return state


def calibrated(api: httpx.Client, truth: Truth, key: dict[str, Any]) -> dict[str, Any]:
    """Calibrate a camera five times; return the consensus."""
    for seed in range(5):
        capture(api, truth, key, seed)
    wanted = key | {"distortion_model": "rectilinear", "redirect": False}

    def found() -> dict[str, Any] | None:
        answer = api.post("/lookup", json=wanted)
        known: dict[str, Any] = answer.json()
        return known if answer.status_code == 200 else None

    known: dict[str, Any] = until(found, TIMEOUT_S)
    return known


def listed(api: httpx.Client, words: str) -> None:
    """Wait until a camera is listed with its models: pages keep what they get."""

    def found() -> bool:
        cameras = api.get("/cameras", params={"query": words}).raise_for_status().json()["cameras"]
        return any(size["models"] for each in cameras for size in each["sizes"])

    until(found, TIMEOUT_S)
