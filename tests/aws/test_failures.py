"""Failure drills: whatever breaks, nothing acknowledged is lost and no answer is wrong.

Others are where their subject is: a killed server and a full disk in test_durability, poisoned requests and
documents of other versions in test_refit, a restore into an empty stack in test_ops_files.
"""

import random
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store, aws
from tests.aws.emulator import LocalStack
from tests.helpers.marks import thorough
from tests.helpers.service.client import BRIEF, TOKEN, Answer, Client, Truth
from tests.helpers.service.published import PLATFORM, asked, calibration, mode_of, store
from tests.helpers.stack import faults

MAX_REPEATS = 60  # times that a client asks again


@pytest.fixture(scope="module")
def stack() -> Iterator[LocalStack]:
    with LocalStack(retry_pauses=(0.01, 0.02)) as stack:
        yield stack


@pytest.fixture
def fresh_stack() -> Iterator[LocalStack]:
    """Yield a stack whose clients may still retry: botocore's give up once many calls have failed."""
    aws.dynamodb.cache_clear()
    aws.s3.cache_clear()
    with LocalStack(retry_pauses=(0.01, 0.02)) as stack:
        yield stack


class Stubborn(Client):
    """A client that asks again when it is told to, as the page does."""

    refused = 0

    def call(self, method: str, path: str, body: object = None, **options: Any) -> Answer:
        for _ in range(MAX_REPEATS):
            answer = super().call(method, path, body, **options)
            if answer.status != 503:
                return answer
            assert answer.headers["retry-after"] == "1"
            self.refused += 1
        raise AssertionError(f"{method} {path}: 503 {MAX_REPEATS} times")


def capture(client: Client, truth: Truth, camera: str) -> tuple[Any, dict[int, int]]:
    """Run a capture; return its last state, and how many points each acknowledged view has."""
    assert client.open(camera=camera, platform=PLATFORM, **BRIEF).status == 201
    acknowledged: dict[int, int] = {}
    for _ in range(12):
        pose = client.pose().json
        ids, points = truth.see(pose)
        answer = client.view(pose["index"], ids, points)
        assert answer.status == 200, answer
        if answer.json["accepted"]:
            acknowledged[pose["index"]] = len(ids)
        if answer.json["status"] == "converged":
            return answer.json, acknowledged
    raise AssertionError("not converged")


def kept(state: Any) -> dict[int, int]:
    return {view["index"]: view["points"] for view in state["views"]}


@pytest.mark.parametrize(
    ("fault", "service"),
    [
        (faults.unheard, "dynamodb"),
        (faults.broken, "s3"),
        *thorough(
            (faults.throttled, "dynamodb"),
            (faults.unheard, "s3"),
            (faults.broken, "dynamodb"),
            (faults.unreached, "dynamodb"),
            (faults.throttled, "s3"),
            (faults.unreached, "s3"),
        ),
    ],
)
def test_capture_completes_when_half_of_the_calls_fail(
    fresh_stack: LocalStack, fault: Any, service: str
) -> None:
    camera = f"Through {fault.__name__} {service}"
    client = Stubborn(fresh_stack)
    with faults.faulty(fault, (service,), share=0.5, seed=1) as met:
        state, acknowledged = capture(client, Truth(seed=3), camera)
    assert len(met) > 5
    assert kept(client.state()) == kept(state) == acknowledged
    stored = client.call("GET", f"/v1/calibrations/{state['calibration_id']}", token=TOKEN).json
    assert stored["camera_matrix"] == state["calibration"]["camera_matrix"]
    document = store(fresh_stack).calibrations.get(state["calibration_id"])
    assert document is not None
    assert {view.index: len(view.ids) for view in document.views} == acknowledged


@pytest.mark.parametrize("fault", [faults.throttled, faults.unreached, *thorough(faults.broken)])
def test_storage_outage_returns_503_and_changes_nothing(stack: LocalStack, fault: Any) -> None:
    client = Client(stack)
    client.open()
    pose = client.pose().json
    seen = Truth(seed=4).see(pose)
    before = client.state()
    with faults.faulty(fault):
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


def test_stale_reads_cause_no_wrong_answer(stack: LocalStack) -> None:
    camera, documents = "Lagging", [calibration("Lagging", n) for n in range(5)]
    client = Client(stack)
    for document in documents[:3]:
        store(stack).calibrations.publish(document)
    mode = mode_of(documents[0])
    with faults.stale() as met:
        assert client.lookup(camera=camera, platform=PLATFORM, redirect=False).status == 404
        store(stack).refit.now(asked(mode, "rectilinear"))
        for document in documents[3:]:
            store(stack).calibrations.publish(document)
        store(stack).refit.now(asked(mode, "rectilinear"))
        # Not known yet is no wrong answer; to vouch for three would be one.
        late = client.lookup(camera=camera, platform=PLATFORM, redirect=False)
        assert late.status == 404 or late.json["calibrations"] == 5
        capture(client, Truth(seed=3), "Captured meanwhile")  # what a session decides by is read as it is
    assert met
    (now,) = store(stack).refit.now(asked(mode, "rectilinear")).models.values()
    assert now is not None
    assert (now.reliable, now.total) == (True, 5)
    assert client.lookup(camera=camera, platform=PLATFORM).json["calibrations"] == 5


def test_clock_skew_of_minutes_is_harmless(stack: LocalStack) -> None:
    """Each call is answered by an instance whose clock is up to two minutes off, either way."""
    rng, lock = random.Random(2), threading.Lock()

    def of(settings: Settings) -> Service:
        with lock:
            off = rng.uniform(-120, 120)
        return Service.build(settings, Store.of(settings), lambda: time.time() + off)

    client = Client(stack)
    with Service.override(of):
        state, acknowledged = capture(client, Truth(seed=3), "Whose clock")
        assert kept(client.state()) == acknowledged
        stack.wait_until_idle(60)
    assert abs(state["calibration"]["calibration_time"] - time.time()) < 130
    key = state["calibration_id"].rpartition("-")[0]
    assert len(store(stack).consensuses.of(key)) == 4
