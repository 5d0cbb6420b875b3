"""Calls that a server runs in its event loop."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from calibdb.service import Service
from calibdb.store.refit import Refit
from infra.server.server import Server
from tests.helpers.service.client import Client
from tests.helpers.service.published import PLATFORM, calibration, publish, store, stored

CAMERA = "Known by all (046d:0825)"


@pytest.fixture
def stack(monkeypatch: pytest.MonkeyPatch) -> Iterator[Server]:
    monkeypatch.setattr("calibdb.service.WRITE_INTERVAL_S", 3600.0)
    with Server() as stack:
        publish(stack, *(calibration(CAMERA, n) for n in range(5)), models=("rectilinear", "fisheye"))
        stack.wait_until_idle(60)
        yield stack


@contextmanager
def writes(stack: Server, monkeypatch: pytest.MonkeyPatch) -> Iterator[list[str]]:
    """Yield the names of the threads that write within the block, the server's own excepted."""
    seen = []
    database = stack.folder.database
    writing = database.writing

    def watched() -> Any:
        if (name := threading.current_thread().name) not in ("upkeep", "jobs"):
            seen.append(name)
        return writing()

    with monkeypatch.context() as patched:
        patched.setattr(database, "writing", watched)
        yield seen


def test_lookup_writes_only_after_its_response(stack: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    client = Client(stack)
    with Service.in_server():
        with writes(stack, monkeypatch) as within:
            answers = [client.lookup(camera=CAMERA, platform=PLATFORM).status for _ in range(20)]
        assert answers == [200] * 20
        assert within == []
        assert list(stack.storage.table.keys("ALIAS#")) == []
    stack.wait_until_idle(60)
    assert len(list(stack.storage.table.keys("ALIAS#"))) == 1


def test_first_use_of_a_trial_token_is_written_after_its_responses(
    stack: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = Client(stack)
    made = client.call("POST", "/v1/tokens", {"origins": ["http://localhost"]}, token="").json
    assert made["expires"] is not None
    client.api_token = made["token"]
    with Service.in_server():
        with writes(stack, monkeypatch) as within:
            answers = [client.lookup(camera=CAMERA, platform=PLATFORM) for _ in range(601)]
        assert [answer.status for answer in answers] == [200] * 600 + [429]
        assert within == []
    facts = client.call("GET", "/v1/tokens/self", token=made["management_token"]).json
    assert facts["expires"] is None
    assert sum(day["lookups"] for day in facts["use"]["days"]) == 600


def test_lookup_that_computes_runs_in_a_thread_and_counts_once(
    stack: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    computed_in, counted = [], []
    compute, count = Refit.now, Service.count_lookup

    def now(self: Refit, request: Any) -> Any:
        computed_in.append(threading.current_thread().name)
        return compute(self, request)

    def count_lookup(self: Service, *arguments: Any) -> Any:
        counted.append(1)
        return count(self, *arguments)

    monkeypatch.setattr(Refit, "now", now)
    monkeypatch.setattr(Service, "count_lookup", count_lookup)
    fisheye = stored(store(stack), calibration(CAMERA, 0), "fisheye")
    assert store(stack).consensuses.drop(fisheye)
    answer = Client(stack).lookup(camera=CAMERA, platform=PLATFORM, distortion_model="fisheye")
    assert answer.status == 200
    assert [name.rpartition("_")[0] for name in computed_in] == ["function"]
    assert counted == [1]
