"""A denied read is never taken for a missing object.

Reads of refit, lookup, export and checks are denied in turn: nothing is concluded and nothing stored, the
answer is 503, and all is well again once the cause is gone. `tests/unit/store/test_aws.py` distinguishes
denied reads from missing objects.
"""

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager

import pytest

from calibdb.errors import DeniedReadError, UnavailableError
from calibdb.store import Store, StreamMode
from functions.refit import app as refit
from infra.server.jobs import Context
from infra.server.server import Server
from tests.helpers.service.client import CAMERA, Answer, Client, Truth
from tests.helpers.service.intercepted import failing
from tests.helpers.service.published import PLATFORM, asked, calibration, mode_of, publish, stored, views

ENVIRONMENT = {"MIN_CALIBRATIONS": "2"}  # five only take longer


@pytest.fixture(autouse=True)
def in_lambda(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_LAMBDA_RUNTIME_API", "127.0.0.1:9001")


def denied(stack: Server, which: Callable[[int], bool] = lambda _: True) -> AbstractContextManager[list[str]]:
    """Deny the reads whose number, from 0, is one of `which`; yields all reads."""
    stack.wait_until_idle(60)
    error = DeniedReadError("Storage denied a read; try again.")
    return failing(stack.storage, error, which, {"GetObject"})


def known(stack: Server, camera: str) -> StreamMode:
    """Publish two calibrations of a camera and the consensus that rests on them; return its mode."""
    documents = [calibration(camera, n) for n in range(2)]
    publish(stack, *documents)
    return mode_of(documents[0])


def counted(capsys: pytest.CaptureFixture[str]) -> int:
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines() if line.startswith('{"_aws"')]
    return sum(line.get("DeniedReads", 0) for line in lines)


def in_turn(reads: int) -> Iterator[Callable[[int], bool]]:
    """Denials: of each read alone, and of each and all that follow."""
    for n in range(reads):
        yield lambda number, n=n: number == n
        yield lambda number, n=n: number >= n


def test_refit_of_denied_or_lost_objects_stores_nothing(
    stack: Server, store: Store, capsys: pytest.CaptureFixture[str]
) -> None:
    mode = known(stack, "Denied")
    third = calibration("Denied", 2)
    store.calibrations.index(third)  # and no object: its content is unknown
    before = store.consensuses.at(mode)
    assert [c.total for c in before] == [2]
    with pytest.raises(UnavailableError):
        store.refit.now(asked(mode, "rectilinear"))
    store.calibrations.publish(third)
    counted(capsys)
    for which in in_turn(3):
        with denied(stack, which), pytest.raises(UnavailableError):
            store.refit.now(asked(mode, "rectilinear"))
        assert store.consensuses.at(mode) == before
    assert counted(capsys) == 6
    (after,) = store.refit.now(asked(mode, "rectilinear")).models.values()
    assert (after.total, after.reliable) == (3, True)


def test_refit_of_the_queue_of_failures_is_done_later(stack: Server, store: Store) -> None:
    mode = known(stack, "Queued")
    store.calibrations.publish(calibration("Queued", 2))
    request = asked(mode).model_copy(update={"queued": True}).model_dump(mode="json")
    with denied(stack), pytest.raises(DeniedReadError):
        refit.handler(request, Context())
    assert {c.total for c in store.consensuses.at(mode)} == {2}
    # Source: AWS Lambda developer guide, "Capturing records of Lambda asynchronous invocations"
    refit.handler({"Records": [{"body": json.dumps({"requestPayload": request})}]}, Context())
    assert {c.total for c in store.consensuses.at(mode)} == {3}


def test_lookup_that_needs_a_denied_read_is_unavailable(stack: Server, store: Store) -> None:
    mode = known(stack, "Looked up")
    before = store.consensuses.at(mode)

    def look() -> Answer:
        return Client(stack).lookup(camera="Looked up", platform=PLATFORM, distortion_model="fisheye")

    for which in in_turn(2):
        with denied(stack, which):
            refused(look())
        assert store.consensuses.at(mode) == before
    assert look().status == 200


def test_export_of_a_denied_calibration_is_unavailable(
    stack: Server, store: Store, client: Client, capsys: pytest.CaptureFixture[str]
) -> None:
    there, withdrawn = (calibration("Exported", n) for n in range(2))
    for document in (there, withdrawn):
        store.calibrations.publish(document)
    store.calibrations.withdraw(withdrawn, "wrong: mirrored", 0)
    # The document is read first, then the tombstone, in whose absence it would be shown.
    for document, status in ((there, 200), (withdrawn, 410)):
        for denied_read in (0, 1):
            with denied(stack, lambda number, n=denied_read: number == n):
                refused(client.calibration(document.id))
        assert client.calibration(document.id).status == status
    assert counted(capsys) == 4


def test_check_whose_reads_are_denied_is_unavailable(stack: Server, store: Store, client: Client) -> None:
    known(stack, "Checked")
    client.authenticate()
    body = {**CAMERA, "camera": "Checked", "platform": PLATFORM, "views": views(Truth(seed=30))}
    before = stored(store, calibration("Checked", 0))
    with denied(stack) as met:
        refused(client.call("POST", "/v1/checks", body))
        assert met
    assert stored(store, calibration("Checked", 0)) == before
    answer = client.call("POST", "/v1/checks", body)
    assert (answer.status, answer.json["votes"]) == (200, {"agree": 1, "disagree": 0})


def refused(answer: Answer) -> None:
    assert (answer.status, answer.headers["retry-after"]) == (503, "1"), answer
