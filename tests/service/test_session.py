"""A session's rules over HTTP."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any
from unittest import mock

import pytest

from calibdb.errors import UnavailableError
from infra.server.server import Server
from tests.helpers.service.client import BRIEF, Answer, Client, Truth, until


def test_a_repeat_does_not_bring_an_undone_view_back(running: Client) -> None:
    view = Truth().see(running.pose().json)
    assert running.view(0, *view).json["accepted"]
    for _ in range(2):  # undoing twice is undoing once
        undone = running.call("DELETE", "/v1/session/views/0")
        assert (undone.status, undone.json["views"]) == (200, [])
        assert undone.json["progress"] == 0
    assert running.view(0, *view).status == 409
    assert running.view(1, *view).json["accepted"]


def shown_to_the_end(client: Client) -> tuple[int, tuple[Any, Any], Answer]:
    """Show views until one ends the capture or fails; return its index, itself, and its answer."""
    truth, status = Truth(), "capturing"
    while status == "capturing":
        index = len(client.state()["views"])
        view = truth.see(client.pose().json)
        answer = client.view(index, *view)
        status = answer.json["status"]
    return index, view, answer


def test_the_last_view_repeated_publishes_once(stack: Server, client: Client) -> None:
    client.open(camera="Camera of a client that repeats", **BRIEF)
    index, view, first = shown_to_the_end(client)
    again = client.view(index, *view)
    assert again.json == first.json
    key = first.json["calibration_id"].rpartition("-")[0]
    name = f"calibrations/{key}/{first.json['calibration_id']}.json"
    assert list(stack.storage.objects.names(f"calibrations/{key}/")) == [name]
    state = client.state()
    assert state["status"] == "converged"
    assert state["uncertainty"]["rms"] <= state["target_error"]
    assert state["calibration"]["id"] == state["calibration_id"]
    assert client.pose().status == 409
    assert client.view(len(state["views"]), *view).status == 409
    assert client.call("DELETE", "/v1/session/views/0").status == 409
    assert client.state() == state


@pytest.mark.parametrize("step", ["calibrations.Calibrations.publish", "refit.Refit.later"])
def test_repeat_completes_a_failed_publication(client: Client, step: str) -> None:
    camera = f"Camera whose {step} fails"
    client.open(camera=camera, **BRIEF)
    with mock.patch(f"calibdb.store.{step}", side_effect=UnavailableError("Storage did not answer.")):
        index, view, answer = shown_to_the_end(client)
    assert answer.status == 503
    assert answer.headers["retry-after"] == "1"
    assert client.lookup(camera=camera).json["reason"] == "unknown_camera"
    again = client.view(index, *view)
    assert (again.status, again.json["status"]) == (200, "converged")
    published = client.calibration(again.json["calibration_id"]).json
    known = again.json["calibration"]
    assert {name: published[name] for name in known} == known
    until(lambda: client.lookup(camera=camera).json["reason"] == "too_few")


@pytest.mark.parametrize("same", [True, False])
def test_views_sent_at_once_have_one_effect(running: Client, same: bool) -> None:
    pose = running.pose().json
    views = [Truth(seed=0 if same else n).see(pose) for n in range(6)]
    with ThreadPoolExecutor(len(views)) as pool:
        answers = list(pool.map(lambda view: running.view(0, *view), views))
    statuses = sorted(answer.status for answer in answers)
    assert statuses == ([200] * 6 if same else [200] + [409] * 5)
    assert len(running.state()["views"]) == 1
    assert running.pose().json["index"] == 1
