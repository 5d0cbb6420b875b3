"""The consensus of a camera."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import pytest

from calibdb import schema
from calibdb.compute import refits
from calibdb.errors import UnavailableError
from calibdb.store import Store
from calibsolver import consensus, deadline
from calibsolver.consensus import fit_memory
from functions.refit import app as refit
from infra.server import jobs
from infra.server.server import Server
from tests.helpers.service.client import Client, until
from tests.helpers.service.published import asked, calibration, mode_of, pooled, stored
from tests.helpers.service.storage_calls import storage_calls
from tests.helpers.service.stores import override_service, with_methods

MODELS = len(schema.DISTORTION_MODELS)


@pytest.fixture(scope="module")
def stack() -> Iterator[Server]:
    with Server(pauses_s=(0.0, 0.0)) as stack:
        yield stack


def totals(store: Store, document: schema.CalibrationDocument) -> list[int]:
    return [known.total for known in store.consensuses.at(mode_of(document))]


def reading_by(read: Callable[[list[str]], list[schema.CalibrationDocument]]) -> Any:
    return override_service(
        lambda store: replace(store, calibrations=with_methods(store.calibrations, read=read))
    )


def test_concurrent_finishes_coalesce_into_one_refit(stack: Server, store: Store) -> None:
    documents = [calibration("Eight at once", n) for n in range(8)]
    mode = mode_of(documents[0])
    ready = threading.Barrier(8)

    def finish(document: schema.CalibrationDocument) -> None:
        ready.wait()
        store.calibrations.publish(document)
        store.refit.later(asked(mode))

    with storage_calls(stack) as seen, ThreadPoolExecutor(8) as pool:
        list(pool.map(finish, documents))
    assert totals(store, documents[0]) == [8] * MODELS
    assert not list(stack.storage.table.keys("REFIT#"))  # nobody holds the lease any more
    assert seen.count("TransactWriteItems") <= 4 * MODELS
    rectilinear = stored(store, documents[0])
    assert (rectilinear.calibration.calibrations, rectilinear.reliable) == (8, True)


def test_overtaken_result_is_not_written(stack: Server, store: Store) -> None:
    documents = [calibration("Overtaken", n) for n in range(2)]
    store.calibrations.publish(documents[0])
    overtaken = []

    def slow(ids: list[str]) -> list[schema.CalibrationDocument]:
        found = store.calibrations.read(ids)
        if not overtaken:  # all is read; now somebody is quicker
            overtaken.append(True)
            store.calibrations.publish(documents[1])
            queued = asked(mode_of(documents[0])).model_copy(update={"queued": True})
            assert stack.storage.jobs.now("refit", queued.model_dump_json().encode()) is not None
        return found

    with reading_by(slow):
        assert pooled(store, documents[0]).total == 2
    assert totals(store, documents[0]) == [2] * MODELS


def test_malformed_refit_is_kept_with_its_error(stack: Server) -> None:
    stack.storage.jobs.later("refit", b'{"camera": 5}')
    failures = "SELECT name, payload, error FROM jobs WHERE error IS NOT NULL"
    [(name, payload, error)] = until(lambda: stack.jobs._database.rows(failures))
    assert (name, json.loads(payload), error.partition(":")[0]) == ("refit", {"camera": 5}, "ValidationError")


def test_failed_refit_is_retried(store: Store) -> None:
    document = calibration("Broken down", 0)
    store.calibrations.publish(document)
    broken = []

    def breaking(ids: list[str]) -> list[schema.CalibrationDocument]:
        if not broken:
            broken.append(True)
            raise UnavailableError("Storage did not answer.")
        return store.calibrations.read(ids)

    with reading_by(breaking):
        store.refit.later(asked(mode_of(document)))
        until(lambda: totals(store, document) == [1] * MODELS)
    assert broken


def test_withdrawn_calibrations_and_models_of_a_later_version_do_not_count(
    stack: Server, store: Store
) -> None:
    documents = [calibration("Withdrawn", n) for n in range(2)]
    for document in documents:
        store.calibrations.publish(document)
    request = asked(mode_of(documents[0]), "double_sphere", "rectilinear")
    for document, total in zip(documents, (1, None), strict=True):
        store.calibrations.withdraw(document, "a mirror", 1)
        models = store.refit.now(request).models
        assert {name: found and found.total for name, found in models.items()} == {"rectilinear": total}
    assert store.consensuses.of(documents[0].camera_key) == []
    assert Client(stack).lookup(camera="Withdrawn").json["reason"] == "unknown_camera"


def test_calibration_off_its_board_is_skipped(store: Store) -> None:
    documents = [calibration("Brought in from elsewhere", n) for n in range(2)]
    views = (documents[1].views[0].model_copy(update={"ids": (999,), "points": ((1.0, 1.0),)}),)
    store.calibrations.publish(documents[0])
    store.calibrations.publish(documents[1].model_copy(update={"views": views}))
    found = pooled(store, documents[0])
    assert (found.total, found.calibration.calibrations) == (2, 1)


def test_consensus_bears_the_label_of_most_contributors_not_of_the_newest(store: Store) -> None:
    label = "Named by many (1234:5678)"
    documents = [calibration(label, n) for n in range(4)]
    for n in (4, 5, 6):  # one contributor, often, and newer than all
        changed = {"camera": label.upper(), "platform": "Linux; Android 14; SM-X1", "source": "f" * 64}
        documents.append(calibration(label, n).model_copy(update=changed | {"contributor": "f" * 64}))
    for document in documents:
        store.calibrations.publish(document)
    found = pooled(store, documents[0])
    assert found.calibration.calibrations == 7
    assert (found.calibration.camera, found.calibration.platform) == (label, documents[0].platform)


def test_what_many_wait_for_is_computed_once(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    document = calibration("Impatient", 0)
    mode = mode_of(document)
    store.calibrations.publish(document)
    reads = []
    together = threading.Barrier(4, timeout=120)

    def read(ids: list[str]) -> list[schema.CalibrationDocument]:
        reads.append(len(ids))
        return store.calibrations.read(ids)

    def compute(_: int) -> schema.RefitAnswer:
        together.wait()
        return store.refit.now(asked(mode, "rectilinear"))

    with reading_by(read), ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(compute, range(4)))
    assert reads == [1]
    assert all(answer == answers[0] for answer in answers)
    # Who computes for longer than a caller waits is not joined by others.
    monkeypatch.setattr(refits, "WAITS_S", (0.01,))
    store.calibrations.publish(calibration("Impatient", 1))
    store.leases.take(mode, "somebody", int(time.time()), int(time.time()) + 60, "NOW#rectilinear")
    with pytest.raises(UnavailableError):
        store.refit.now(asked(mode, "rectilinear"))


def test_refit_ends_before_its_invocation_does(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    document = calibration("Takes too long", 0)
    store.calibrations.publish(document)
    assert 5 <= refit.MIN_PUBLISHING_S < jobs.TIMEOUT_S / 2
    fit_memory.forget()  # what is remembered takes no time
    with monkeypatch.context() as patch:
        patch.setattr(jobs, "TIMEOUT_S", refit.MIN_PUBLISHING_S)
        with pytest.raises(UnavailableError):
            store.refit.now(asked(mode_of(document)))
    assert store.consensuses.at(mode_of(document)) == []
    assert pooled(store, document).total == 1


def test_refit_that_runs_out_of_time_stores_whole_models_and_continues(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    document = calibration("Out of time", 0)
    store.calibrations.publish(document)
    pool, pooled, last = consensus.pool, [], 1

    def pool_some(*given: Any) -> Any:
        if len(pooled) == last:
            with deadline.limit(lambda: 0.0):
                deadline.check()
        pooled.append(given[2])
        return pool(*given)

    monkeypatch.setattr(consensus, "pool", pool_some)
    with pytest.raises(UnavailableError):
        store.refit.now(asked(mode_of(document)))
    assert [known.distortion_model for known in store.consensuses.at(mode_of(document))] == pooled
    assert len(pooled) == 1
    last = 99
    assert set(store.refit.now(asked(mode_of(document))).models) == set(schema.DISTORTION_MODELS)
    assert sorted(pooled) == sorted(schema.DISTORTION_MODELS)
