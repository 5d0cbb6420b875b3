"""Cameras whose calibrations fall into groups."""

import math
from collections.abc import Iterator
from typing import Any

import pytest

from calibdb_client import Board, CameraKey
from calibdb_client import Client as PythonClient
from calibdb_client.recording import RecordedView, Recording
from infra.server.server import Server
from tests.helpers.service import published
from tests.helpers.service.client import TOKEN, Answer, Client, Truth
from tests.helpers.service.published import PLATFORM, calibration, publish, store

NAME = "Two fields of view"
MODES = {"wide": 760.0, "narrow": 950.0}


@pytest.fixture(scope="module")
def stack() -> Iterator[Server]:
    """Two calibrations of each mode: neither is in the majority that a consensus needs."""
    with Server(environment={"MIN_CALIBRATIONS": "3"}) as stack:
        focals = enumerate((950.0, 760.0, 953.0, 758.0))
        publish(stack, *(calibration(NAME, n, fx=fx, fy=fx - 2) for n, fx in focals))
        yield stack


def views(fx: float, count: int = 3, **options: Any) -> list[dict[str, Any]]:
    return published.views(Truth(fx=fx, fy=fx - 2, seed=100), count, **options)


def look(stack: Server, **body: Any) -> Answer:
    return Client(stack).lookup(camera=NAME, platform=PLATFORM, miss="ok", **body)


def hfov(fx: float) -> float:
    return 2 * math.degrees(math.atan(640 / fx))


def test_without_views_the_calibrations_disagree(stack: Server) -> None:
    found = look(stack).json
    assert (found["reason"], found["estimate"]["basis"]) == ("disagree", "calibrations")
    assert "group" not in found["estimate"]


@pytest.mark.parametrize(("mode", "count"), [("wide", 2), ("narrow", 5)])
def test_views_pick_the_mode(stack: Server, mode: str, count: int) -> None:
    fx = MODES[mode] * 1.004  # another specimen
    found = look(stack, views=views(fx, count)).json
    assert found["calibration"] is None
    estimate = found["estimate"]
    assert (estimate["basis"], estimate["group"]) == ("views", f"{hfov(MODES[mode]):.0f}°")
    assert estimate["hfov_deg"] == pytest.approx(hfov(fx), abs=1)
    low, high = estimate["interval_90"]["hfov_deg"]
    assert low < hfov(fx) < high
    assert high - low < 0.2 * hfov(fx)
    assert estimate["distortion_coefficients"][0] == pytest.approx(-0.12, abs=0.03)


def test_views_of_neither_mode_and_of_both_change_nothing(stack: Server) -> None:
    """A board held parallel to the picture looks alike at any focal length."""
    plain = look(stack).json["estimate"]
    points = [[240 + 100 * x, 160 + 100 * y] for y in range(5) for x in range(8)]
    for ambiguous in (views(1400.0), [{"ids": [*range(40)], "points": points}]):
        assert look(stack, views=ambiguous).json["estimate"] == plain


def test_corners_that_the_board_does_not_have_are_refused(stack: Server) -> None:
    wrong = look(stack, views=[{"ids": [0, 1, 400], "points": [[1, 1], [2, 2], [3, 3]]}])
    assert wrong.fields == ["views.0.ids.2"]
    assert look(stack, views=views(950.0, 3) * 2).status == 422


def test_nothing_is_stored(stack: Server) -> None:
    key = calibration(NAME, 0).camera_key
    before = store(stack).cameras.known(key).consensuses
    look(stack, views=views(950.0))
    assert store(stack).cameras.known(key).consensuses == before


def test_python_client_sends_views(stack: Server) -> None:
    key = CameraKey(NAME, PLATFORM, (1280, 720), 0.0)
    seen = tuple(
        RecordedView(f"view {n}", tuple(view["ids"]), tuple(map(tuple, view["points"])))
        for n, view in enumerate(views(760.0, 4))
    )
    with stack.serve() as url, PythonClient(url, TOKEN, cache=False) as client:
        found = client.lookup(key, views=Recording(key, Board((9, 6)), seen))
    assert (found.estimate.basis, found.estimate.group) == ("views", f"{hfov(760):.0f}°")
