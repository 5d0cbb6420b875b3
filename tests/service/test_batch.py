"""Several views of a recorded session in one request."""

from typing import Any

import numpy as np
import pytest

from calibdb.http.call import Call
from calibsolver.capture import Capture
from tests.helpers.service.client import Answer, Client, Truth
from tests.helpers.service.published import mirrored, views

JOBS = False
Corners = dict[str, Any]


@pytest.fixture
def corners() -> list[Corners]:
    return views(Truth(), 8)


@pytest.fixture
def recorded(client: Client) -> Client:
    assert client.open(camera="Batch", capture="recorded").status == 201
    return client


def send(client: Client, views: list[Corners], index: int = 0) -> Answer:
    return client.call("POST", "/v1/session/batch", {"index": index, "views": views})


def test_batch_gives_the_results_and_the_camera_of_single_views(
    client: Client, corners: list[Corners]
) -> None:
    bad = mirrored(corners[2])
    mixed = [*corners[:4], bad, *corners[4:]]
    client.open(camera="One by one", capture="recorded")
    single, taken = [], 0
    for view in mixed:
        answer = client.view(taken, view["ids"], view["points"]).json
        taken += answer["accepted"]
        single.append((answer["accepted"], answer["reason"]))
    one_by_one = client.finish().json
    client.open(camera="One by one", capture="recorded")
    answer = send(client, mixed).json
    assert [(result["accepted"], result["reason"]) for result in answer["results"]] == single
    assert single.count((True, None)) == 8
    assert [result["index"] for result in answer["results"]] == [0, 1, 2, 3, None, 4, 5, 6, 7]
    errors = [result["error"] for result in answer["results"] if result["error"] is not None]
    assert errors[-1] == answer["uncertainty"]["rms"] < errors[0]
    assert len(answer["views"]) == 8
    matrices = [state["calibration"]["camera_matrix"] for state in (client.finish().json, one_by_one)]
    assert np.allclose(*matrices, atol=0.01)


def test_repeated_batch_adds_nothing_and_returns_the_same_indices(
    recorded: Client, corners: list[Corners]
) -> None:
    first = send(recorded, corners[:5])
    assert send(recorded, corners[:5]).json == first.json
    reordered = [{"ids": view["ids"][::-1], "points": view["points"][::-1]} for view in corners[:5]]
    assert send(recorded, reordered).json["results"] == first.json["results"]
    more = send(recorded, corners[3:], index=5).json
    assert [result["index"] for result in more["results"]] == [5, 6, 7, 8, 9], "it is not a repeated one"
    assert send(recorded, corners[:1], index=11).problem == (409, "index-not-open")
    assert recorded.call("DELETE", "/v1/session/views/9").status == 200
    assert send(recorded, corners[3:], index=5).problem == (409, "index-not-open"), "it stays undone"


def test_finished_session_repeats_results_and_takes_no_more(recorded: Client, corners: list[Corners]) -> None:
    first = send(recorded, corners[:5]).json["results"]
    assert recorded.finish().status == 200
    assert send(recorded, corners[:5]).json["results"] == first
    assert send(recorded, corners, index=0).problem == (409, "converged")


def test_wrong_views_are_named_each_once_and_nothing_is_judged(
    recorded: Client, corners: list[Corners]
) -> None:
    outside = {**corners[1], "points": [[1281, 10]] * len(corners[1]["ids"])}
    unknown = {**corners[3], "ids": [900 + i for i in corners[3]["ids"]]}
    wrong = send(recorded, [corners[0], outside, corners[2], unknown]).fields
    assert wrong == ["views.1.points.0", "views.3.ids.0"]
    short = {**corners[1], "points": corners[1]["points"][:-1]}
    assert send(recorded, [corners[0], short]).fields == ["views.1.points"]
    assert send(recorded, [corners[0]] * 201).status == 422
    assert recorded.state()["views"] == []


def test_session_of_batches_has_the_limits_of_single_views(
    recorded: Client, corners: list[Corners], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("calibdb.rules.session_rules.MAX_RECORDED_VIEWS", 6)
    assert send(recorded, corners).problem == (409, "session-full")
    assert recorded.state()["views"] == []
    assert send(recorded, corners[:6]).status == 200
    assert send(recorded, corners[6:], index=6).problem == (409, "session-full")
    monkeypatch.setattr("calibdb.rules.session_rules.MAX_POINTS", 100)
    assert send(recorded, corners[6:], index=6).problem == (409, "session-full")


def test_only_recorded_sessions_take_batches(client: Client, corners: list[Corners]) -> None:
    client.open(camera="Live")
    assert send(client, corners).problem == (409, "not-recorded")


@pytest.mark.parametrize("left_s", [0.5, 2.0], ids=["before the fourth view", "in the fourth view"])
def test_batch_without_time_returns_the_results_it_has(
    recorded: Client, corners: list[Corners], monkeypatch: pytest.MonkeyPatch, left_s: float
) -> None:
    judge, judged = Capture.judge, []
    after_third = iter([left_s])

    def counted(*arguments: Any, **options: Any) -> Any:
        judged.append(judge(*arguments, **options))
        return judged[-1]

    def seconds_left(_: Call) -> float:
        return 2.0 if len(judged) < 3 else next(after_third, 0.0)

    with monkeypatch.context() as patch:
        patch.setattr(Call, "seconds_left", seconds_left)
        patch.setattr(Capture, "judge", counted)
        answer = send(recorded, corners).json
    assert [result["index"] for result in answer["results"]] == [0, 1, 2]
    assert len(recorded.state()["views"]) == 3
    rest = send(recorded, corners[3:], index=3).json
    assert [result["index"] for result in rest["results"]] == [3, 4, 5, 6, 7]
    with monkeypatch.context() as patch:
        patch.setattr(Call, "seconds_left", lambda _: 0.0)
        assert send(recorded, corners[:1], index=8).status in (409, 503)
