"""A session's rules over HTTP."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

from calibdb.errors import UnavailableError
from calibdb.store import Store
from infra.server.server import Server
from tests.helpers.service.client import BRIEF, Client, Truth, until
from tests.helpers.service.stores import override_service, with_methods


@pytest.fixture
def converged(client: Client) -> Client:
    Truth().calibrate(client, **BRIEF)
    return client


def test_a_repeat_does_not_bring_an_undone_view_back(running: Client) -> None:
    view = Truth().see(running.pose().json)
    assert running.view(0, *view).json["accepted"]
    for _ in range(2):  # undoing twice is undoing once
        undone = running.call("DELETE", "/v1/session/views/0")
        assert (undone.status, undone.json["views"]) == (200, [])
        assert undone.json["progress"] == 0
    assert running.view(0, *view).status == 409
    assert running.view(1, *view).json["accepted"]


def test_converged_session_is_immutable(converged: Client) -> None:
    state = converged.state()
    assert state["status"] == "converged"
    assert state["uncertainty"]["rms"] <= state["target_error"]
    assert state["calibration"]["id"] == state["calibration_id"]
    view = Truth(seed=9).see({"rvec": [0.3, 0, 0], "tvec": [-4, -3, 9]})
    assert converged.pose().status == 409
    assert converged.view(len(state["views"]), *view).status == 409
    assert converged.call("DELETE", "/v1/session/views/0").status == 409
    assert converged.state() == state


def test_the_last_view_repeated_publishes_once(stack: Server, client: Client) -> None:
    truth = Truth()
    client.open(camera="Camera of a client that repeats", **BRIEF)
    while True:
        pose = client.pose().json
        view = truth.see(pose)
        first = client.view(pose["index"], *view)
        if first.json["status"] == "converged":
            break
    again = client.view(pose["index"], *view)
    assert again.json == first.json
    key = first.json["calibration_id"].rpartition("-")[0]
    name = f"calibrations/{key}/{first.json['calibration_id']}.json"
    assert list(stack.storage.objects.names(f"calibrations/{key}/")) == [name]


@pytest.mark.parametrize(("noun", "verb"), [("calibrations", "publish"), ("refit", "later")])
def test_repeat_completes_a_failed_publication(client: Client, noun: str, verb: str) -> None:
    truth, camera = Truth(), f"Camera whose {verb} fails"
    client.open(camera=camera, **BRIEF)

    def fail(*_: object) -> None:
        raise UnavailableError("Storage did not answer.")

    def broken(store: Store) -> Store:
        part = with_methods(getattr(store, noun), **{verb: fail})
        return replace(store, **{noun: part})

    with override_service(broken):
        status = 200
        while status == 200:
            pose = client.pose().json
            view = truth.see(pose)
            answer = client.view(pose["index"], *view)
            status = answer.status
    assert answer.status == 503
    assert answer.headers["retry-after"] == "1"
    assert client.lookup(camera=camera).json["reason"] == "unknown_camera"
    again = client.view(pose["index"], *view)
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
