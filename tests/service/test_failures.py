"""Failure drills: whatever breaks, nothing acknowledged is lost and no answer is wrong.

Others are where their subject is: a killed server and a full disk in test_durability, poisoned requests and
documents of other versions in test_refit, a restore into an empty stack in test_ops_files.
"""

import functools
import random
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import pytest

from calibdb.errors import UnavailableError
from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store
from calibdb.store.storage import opened
from infra.server.server import Server
from tests.helpers.marks import thorough
from tests.helpers.service.client import BRIEF, TOKEN, Answer, Client, Truth
from tests.helpers.service.intercepted import failing
from tests.helpers.service.published import PLATFORM, calibration, pooled
from tests.helpers.service.stores import override_service, with_methods

MAX_REPEATS = 60  # times that a client asks again


UNREACHED = UnavailableError("Storage did not answer.")


@dataclass
class Stubborn(Client):
    """A client that asks again when the service says so, as the page does, and notes its accepted views."""

    acknowledged: dict[int, int] = field(default_factory=dict)  # number of points by index
    refused: int = 0

    def call(self, method: str, path: str, body: object = None, **options: Any) -> Answer:
        for _ in range(MAX_REPEATS):
            answer = super().call(method, path, body, **options)
            if answer.status != 503:
                return answer
            assert answer.headers["retry-after"] == "1"
            self.refused += 1
        raise AssertionError(f"{method} {path}: 503 {MAX_REPEATS} times")

    def view(self, index: float, ids: Any, points: object) -> Answer:
        answer = super().view(index, ids, points)
        if answer.json["accepted"]:
            self.acknowledged[index] = len(ids)
        return answer


def kept(state: Any) -> dict[int, int]:
    return {view["index"]: view["points"] for view in state["views"]}


@pytest.mark.parametrize("heard", [False, *thorough(True)])
def test_capture_completes_when_calls_of_storage_fail(stack: Server, store: Store, heard: bool) -> None:
    client, rng = Stubborn(stack), random.Random(1)
    with failing(stack.storage, UNREACHED, lambda _: rng.random() < 0.15, heard=heard):
        state = Truth(seed=3).calibrate(client, camera=f"Not heard: {heard}", **BRIEF)
    assert client.refused > 5
    assert kept(client.state()) == kept(state) == client.acknowledged
    shown = client.call("GET", f"/v1/calibrations/{state['calibration_id']}", token=TOKEN).json
    assert shown["camera_matrix"] == state["calibration"]["camera_matrix"]
    document = store.calibrations.get(state["calibration_id"])
    assert {view.index: len(view.ids) for view in document.views} == client.acknowledged


def test_storage_outage_returns_503_and_changes_nothing(stack: Server, client: Client) -> None:
    client.open()
    pose = client.pose().json
    seen = Truth(seed=4).see(pose)
    before = client.state()
    with failing(stack.storage, UNREACHED):
        for answer in (
            client.view(pose["index"], *seen),
            client.call("GET", "/v1/session"),
            client.call("DELETE", "/v1/session"),
            client.lookup(),
        ):
            assert (answer.status, answer.headers["retry-after"]) == (503, "1")
            assert b"Traceback" not in answer.body
    assert client.state() == before
    assert client.view(pose["index"], *seen).json["accepted"]


@contextmanager
def stale(stack: Server) -> Iterator[list[Any]]:
    """Reads that may be eventually consistent answer as they first did within the block; yields memories."""
    table, memories = stack.storage.table, []

    def remembering(read: Callable[..., Any], *, is_consistent: bool) -> Callable[..., Any]:
        remembered = functools.cache(functools.partial(read, consistent=False))
        memories.append(remembered)

        def answer(*key: str, consistent: bool = is_consistent, **options: Any) -> Any:
            return read(*key, consistent=True, **options) if consistent else remembered(*key, **options)

        return answer

    lagging = with_methods(
        table,
        get=remembering(table.get, is_consistent=True),
        query=remembering(table.query, is_consistent=False),
    )
    with opened(replace(stack.storage, table=lagging)), override_service():
        yield memories


def test_stale_reads_cause_no_wrong_answer(stack: Server, store: Store, client: Client) -> None:
    camera, documents = "Lagging", [calibration("Lagging", n) for n in range(5)]
    for document in documents[:3]:
        store.calibrations.publish(document)
    with stale(stack) as memories:
        assert client.lookup(camera=camera, platform=PLATFORM, redirect=False).status == 404
        assert pooled(store, documents[0]).total == 3
        for document in documents[3:]:
            store.calibrations.publish(document)
        assert pooled(store, documents[0]).total == 5
        # "Not known yet" is right; a consensus of three would be wrong.
        late = client.lookup(camera=camera, platform=PLATFORM, redirect=False)
        assert late.status == 404 or late.json["calibrations"] == 5
        # What a session decides by is read as it is.
        Truth(seed=3).calibrate(client, camera="Captured meanwhile", **BRIEF)
    assert sum(memory.cache_info().hits for memory in memories) > 0
    now = pooled(store, documents[0])
    assert (now.reliable, now.total) == (True, 5)
    assert client.lookup(camera=camera, platform=PLATFORM).json["calibrations"] == 5


def test_clock_skew_of_minutes_is_harmless(stack: Server, store: Store) -> None:
    """Each call is answered by an instance whose clock is up to two minutes off, either way."""
    client = Stubborn(stack)
    rng, lock = random.Random(2), threading.Lock()

    def of(settings: Settings) -> Service:
        with lock:
            off = rng.uniform(-120, 120)
        return Service.build(settings, Store.of(settings), lambda: time.time() + off)

    with Service.override(of):
        state = Truth(seed=3).calibrate(client, camera="Whose clock", **BRIEF)
        assert kept(client.state()) == client.acknowledged
        stack.wait_until_idle(60)
    assert abs(state["calibration"]["calibration_time"] - time.time()) < 130
    key = state["calibration_id"].rpartition("-")[0]
    assert len(store.consensuses.of(key)) == 4
