"""Cameras whose calibrations fall into groups, and the names of these."""

import math
from collections.abc import Iterator
from typing import Any

import pytest

from calibdb_client import Board, CameraKey
from calibdb_client import Client as PythonClient
from calibdb_client.recording import RecordedView, Recording
from infra.server.server import Server
from tests.helpers.service import published
from tests.helpers.service.client import BRIEF, TOKEN, Answer, Client, Truth
from tests.helpers.service.published import PLATFORM, calibration, store

NAME = "Two fields of view"
MODES = {"Off": 760.0, "Stabilisation on": 950.0}


def publish(stack: Server, camera: str, *names: str | None) -> None:
    """Publish two calibrations of each mode: neither is in the majority that a consensus needs."""
    made = [calibration(camera, n, fx=fx, fy=fx - 2) for n, fx in enumerate((950.0, 760.0, 953.0, 758.0))]
    documents = (d.model_copy(update={"mode_name": name}) for d, name in zip(made, names, strict=True))
    published.publish(stack, *documents)


@pytest.fixture(scope="module")
def stack() -> Iterator[Server]:
    with Server(environment={"MIN_CALIBRATIONS": "3"}) as stack:
        publish(stack, NAME, "Stabilisation on", "Off", "stabilisation on", None)
        yield stack


def views(fx: float, count: int = 3, **options: Any) -> list[dict[str, Any]]:
    return published.views(Truth(fx=fx, fy=fx - 2, seed=100), count, **options)


def look(stack: Server, **body: Any) -> Answer:
    return Client(stack).lookup(**{"camera": NAME, "platform": PLATFORM, "miss": "ok", **body})


def hfov(fx: float) -> float:
    return 2 * math.degrees(math.atan(640 / fx))


def test_without_views_the_calibrations_disagree(stack: Server) -> None:
    found = look(stack).json
    assert (found["reason"], found["estimate"]["basis"]) == ("disagree", "calibrations")
    assert "group" not in found["estimate"]


@pytest.mark.parametrize(("mode", "count"), [("Off", 2), ("Stabilisation on", 5)])
def test_views_pick_the_mode(stack: Server, mode: str, count: int) -> None:
    fx = MODES[mode] * 1.004  # another specimen
    found = look(stack, views=views(fx, count)).json
    assert found["calibration"] is None
    estimate = found["estimate"]
    assert (estimate["basis"], estimate["group"]) == ("views", mode)
    assert estimate["hfov_deg"] == pytest.approx(hfov(fx), abs=1)
    low, high = estimate["interval_90"]["hfov_deg"]
    assert low < hfov(fx) < high
    assert high - low < 0.2 * hfov(fx)
    assert estimate["distortion_coefficients"][0] == pytest.approx(-0.12, abs=0.03)


def test_camera_page_names_its_groups(stack: Server) -> None:
    key = calibration(NAME, 0).camera_key
    (mode,) = Client(stack).call("GET", f"/v1/cameras/{key}").json["modes"]
    focals = {member["id"]: member["fx"] for member in mode["members"]}
    shown = {focals[group[0]]: name for group, name in zip(mode["groups"], mode["group_names"], strict=True)}
    assert {name: pytest.approx(fx, rel=0.02) for fx, name in shown.items()} == MODES


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
    assert (found.estimate.basis, found.estimate.group) == ("views", "Off")


def test_operator_removes_a_name(stack: Server) -> None:
    camera = "With a rude name"
    publish(stack, camera, "Rude", None, None, None)

    def group() -> Any:
        return look(stack, camera=camera, views=views(952.0)).json["estimate"]["group"]

    assert group() == "Rude"
    (named,) = (one for one in store(stack).calibrations.all() if one.mode_name == "Rude")
    assert store(stack).calibrations.remove_mode_name(named.id)
    assert not store(stack).calibrations.remove_mode_name(named.id)
    store(stack).calibrations.publish(named)  # its session ends again
    assert group() == "68°"


def test_contributor_names_the_mode(client: Client) -> None:
    ended = Truth(seed=3).calibrate(client, camera="Named Z1", mode_name="  Linear + Horizon ", **BRIEF)
    stored = store(client.stack).calibrations.get(ended["calibration_id"])
    assert stored.mode_name == "Linear + Horizon"
    assert client.open(mode_name="<b>wide</b>").fields == ["mode_name"]
