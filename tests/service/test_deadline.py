"""Deadline of a request."""

import json
from types import SimpleNamespace
from typing import Any

import pytest
from starlette.requests import Request

from calibdb.access.plans import PLANS
from calibdb.errors import ConflictError, UnavailableError
from calibdb.http import call as calls
from calibdb.http.call import Call
from calibdb.rules.rig_state import Rig
from calibdb.service import Service
from infra.server.server import Server
from tests.helpers.service.client import BRIEF, Client, Truth
from tests.helpers.service.published import views
from tests.helpers.service.rigs import RigTruth
from tests.helpers.service.strangers import standing_clock


@pytest.fixture(scope="module")
def calibration(stack: Server) -> str:
    return str(Truth(seed=3).calibrate(Client(stack), **BRIEF)["calibration_id"])


def without_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calls, "MAX_COMPUTE_S", 0.0)


def test_view_that_takes_too_long_is_a_conflict_and_changes_nothing(
    running: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    truth = Truth()
    for _ in range(2):
        assert truth.show(running).json["accepted"]
    seen = truth.see(running.pose().json)
    before = running.state()
    with monkeypatch.context() as patch:
        without_time(patch)
        answer = running.view(2, *seen)
        undone = running.call("DELETE", "/v1/session/views/1")
    assert answer.problem == undone.problem == (409, "too-slow")
    assert "fewer" in answer.json["detail"]
    assert running.state() == before
    assert running.view(2, *seen).json["accepted"]


@pytest.mark.parametrize(
    ("query", "field"), [("format=gyroflow", "format"), ("without=0", "without"), ("format=kalibr", "format")]
)
def test_export_that_takes_too_long_is_unprocessable(
    client: Client, calibration: str, monkeypatch: pytest.MonkeyPatch, query: str, field: str
) -> None:
    without_time(monkeypatch)
    answer = client.calibration(calibration, query)
    assert answer.fields == [field]


@pytest.mark.usefixtures("calibration")
def test_check_that_takes_too_long_is_unprocessable(
    stack: Server, client: Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    stack.wait_until_idle(60)
    without_time(monkeypatch)
    assert client.check(views(Truth(seed=2))).fields == ["views"]


def test_rig_that_takes_too_long_is_a_conflict_and_stays(
    stack: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = RigTruth(stack, seed=3).open()
    rig.moment("m0")
    rig.moment("m1")
    with monkeypatch.context() as patch:
        patch.setattr(calls, "MAX_RIG_COMPUTE_S", 0.0)
        for answer in (rig.call("GET"), rig.call("POST", "/finish")):
            assert answer.problem == (409, "too-slow")
    undone = rig.call("DELETE", "/moments/m1")
    assert undone.status == 200, undone.body
    assert [moment["positions"] for moment in rig.state()["moments"]] == [[0, 1]]


def test_rig_that_took_too_long_is_charged_as_a_view_and_not_computed_by_every_read(
    stack: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    computed = []
    solver_record = Rig.solver_record

    def counted(rig: Rig, basis: str) -> dict[str, Any]:
        computed.append(basis)
        return solver_record(rig, basis)

    monkeypatch.setattr(Rig, "solver_record", counted)
    with standing_clock(plans={**PLANS, "development": PLANS["page"]}) as clock:
        quotas = Service.of_process().store.quotas
        rig = RigTruth(stack, seed=3).open()
        rig.moment("m0")
        for bound, times in ((0.0, 1), (5.2, 0)):
            monkeypatch.setattr(calls, "MAX_RIG_COMPUTE_S", bound)
            computed.clear()
            before = quotas.used("dev", int(clock()))["views"]
            assert [rig.call("GET", position=n % 2).status for n in range(6)] == [409] * 6
            assert rig.clients[1].pose().status == 409
            assert len(computed) == times
            assert quotas.used("dev", int(clock()))["views"] - before == times


def made(remaining_ms: int, used_s: float, factor: float = 1.0) -> Call:
    context = SimpleNamespace(get_remaining_time_in_millis=lambda: remaining_ms)
    request = Request({"type": "http", "headers": [], "aws.context": context})
    settings = SimpleNamespace(processor_factor=factor)
    service = SimpleNamespace(settings=settings, clock=lambda: 1.7e9)
    return Call(request, b"", service, processor_s=lambda: used_s, begun_s=0.0)


def test_time_left_is_the_lesser_of_processor_and_invocation() -> None:
    assert made(10_000, 2.0).seconds_left() == pytest.approx(0.8)
    assert made(3_000, 0.0).seconds_left() == pytest.approx(1.5)
    half_as_fast = made(29_000, 4.0, 2.0)
    assert half_as_fast.seconds_left() == pytest.approx(0.8)
    assert half_as_fast.with_time_for_a_rig().seconds_left() == pytest.approx(5.2 - 4.0 / 2)


def test_request_that_ran_out_of_time_is_counted(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("AWS_LAMBDA_RUNTIME_API", "127.0.0.1:9001")
    reason = ConflictError("too slow")
    assert isinstance(made(0, 1.0).out_of_time(reason), UnavailableError)
    assert made(10_000, 2.8).out_of_time(reason) is reason
    lines = capsys.readouterr().out.splitlines()
    assert [json.loads(line)["ComputeTimeouts"] for line in lines] == [1, 1]
