"""Health of the parts: each told for itself, in bounded time, seldom enough, and with no word of why."""

import threading
import time
from typing import Any
from urllib.request import OpenerDirector

import pytest

from calibdb.compute import solver_check
from calibdb.errors import UnavailableError
from calibdb.http.part_checks import CHECKS_TTL_S, Part, PartChecks
from calibdb.schema.health import CanaryRun
from calibdb.store.canary import EXPIRY_S, store_canary_run
from calibdb.store.sqlite import SqliteObjects, SqliteTable
from infra.server.server import Server
from tests.helpers.service.client import Answer, Client

PARTS = ["table", "bucket", "edge", "solver"]
SECRETS = "arn:aws:dynamodb:table/secret-name key=AKIA"


@pytest.fixture
def client(stack: Server, url: str) -> Client:  # noqa: ARG001 - the edge is asked at this address
    return Client(stack)


@pytest.fixture(autouse=True)
def _never_cached(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("calibdb.http.part_checks.CHECKS_TTL_S", 0.0)


def deep(client: Client) -> Answer:
    return client.call("GET", "/healthz", query="deep=1")


def states(answer: Any) -> dict[str, bool]:
    return {part["part"]: part["ok"] for part in answer["parts"]}


def test_every_part_is_checked_with_its_latency(client: Client) -> None:
    answer = deep(client)
    assert answer.status == 200
    assert answer.headers["cache-control"] == "public, max-age=5, s-maxage=10"
    body = answer.json
    assert (body["status"], body["canary"]) == ("ok", None)
    assert [part["part"] for part in body["parts"]] == PARTS
    assert all(0 <= part["latency_ms"] <= part["limit_ms"] for part in body["parts"])
    assert sum(part["limit_ms"] for part in body["parts"]) <= 20_000  # of the gateway's 30 s


def test_plain_answer_checks_nothing(client: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PartChecks, "__call__", fail)
    for query in ("", "deep=0"):
        answer = client.call("GET", "/healthz", query=query)
        assert (answer.status, answer.json) == (200, {"status": "ok"})
        assert answer.headers["cache-control"] == "no-store"
    assert client.call("GET", "/healthz", query="deep=all").status == 422


def fail(*_: object, **__: object) -> Any:
    raise UnavailableError(SECRETS)


@pytest.mark.parametrize(
    ("part", "owner", "method"),
    [
        ("table", SqliteTable, "get"),
        ("bucket", SqliteObjects, "get"),
        ("edge", OpenerDirector, "open"),
        ("solver", solver_check, "fit"),
    ],
)
def test_part_that_fails_is_named_and_nothing_of_why(
    client: Client, monkeypatch: pytest.MonkeyPatch, part: str, owner: Any, method: str
) -> None:
    monkeypatch.setattr(owner, method, fail)
    answer = deep(client)
    assert answer.problem == (503, "unhealthy")
    assert answer.headers["cache-control"] == "public, max-age=5, s-maxage=10"
    body = answer.json
    assert states(body) == {name: name != part for name in PARTS}
    assert [each["latency_ms"] for each in body["parts"] if not each["ok"]] == [None]
    names = (client.stack.environment[f"{name}_NAME"] for name in ("TABLE", "BUCKET"))
    for secret in (SECRETS, "Error", *names):
        assert secret.encode() not in answer.body
    assert client.call("GET", "/healthz").status == 200


def test_failed_canary_is_shown_until_it_is_old(client: Client) -> None:
    table, now = client.stack.storage.table, int(time.time())
    run = CanaryRun(ok=False, at=now, took_ms=900, failed_at="view")
    store_canary_run(table, run)
    answer = deep(client)
    assert answer.status == 503
    assert answer.json["canary"] == {"ok": False, "at": now, "took_ms": 900, "failed_at": "view"}
    assert all(states(answer.json).values())
    store_canary_run(table, CanaryRun(ok=True, at=now, took_ms=900))
    assert deep(client).json["canary"]["ok"] is True
    store_canary_run(table, run.model_copy(update={"at": now - EXPIRY_S}))
    assert deep(client).json["canary"] is None  # it was switched off


def test_slow_part_takes_its_own_time_and_is_not_asked_again_meanwhile() -> None:
    release, asked = threading.Event(), []

    def hang() -> None:
        asked.append(1)
        release.wait(30)

    slow = Part("edge", 0.05, hang)
    table, solver = (Part(name, 5.0, lambda: None) for name in ("table", "solver"))
    checks = PartChecks(((slow, table), (solver,)))
    start = time.monotonic()
    for _ in range(5):
        assert {found.part: found.ok for found in checks()} == {"edge": False, "table": True, "solver": True}
    assert time.monotonic() - start < 5
    assert len(asked) == 1
    release.set()


def test_parts_are_checked_once_in_ten_seconds_however_many_ask(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    asked = []
    now = [0.0]
    checks = PartChecks(((Part("table", 5.0, lambda: asked.append(1)),),), lambda: now[0])
    threads = [threading.Thread(target=checks) for _ in range(20)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(asked) == 1
    now[0] = CHECKS_TTL_S
    checks()
    assert len(asked) == 2
