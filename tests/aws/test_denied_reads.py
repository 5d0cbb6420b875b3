"""A denied read is never taken for a missing object.

S3 says the same of both to whom may not list. Every read of refit, lookup, export and checks is denied in
turn, once and for ever: nothing is concluded and nothing stored, the answer is 503, and all is well again
once the cause is gone.
"""

import json
from collections.abc import Callable, Iterator

import pytest

from calibdb.errors import UnavailableError
from calibdb.store import StreamMode
from tests.aws.emulator import LocalStack
from tests.helpers.service.client import CAMERA, TOKEN, Answer, Client, Truth
from tests.helpers.service.published import PLATFORM, asked, calibration, held, mode_of, store
from tests.helpers.stack import faults

VIEWS = [{"ids": ids, "points": points} for ids, points in held(Truth(seed=30), 3)]


@pytest.fixture(scope="module")
def stack() -> Iterator[LocalStack]:
    """Two calibrations are enough here; five only take longer."""
    with LocalStack({"MIN_CALIBRATIONS": "2"}, retry_pauses=(0.01, 0.02)) as stack:
        yield stack


@pytest.fixture(autouse=True)
def in_lambda(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_LAMBDA_RUNTIME_API", "127.0.0.1:9001")


def known(stack: LocalStack, camera: str) -> StreamMode:
    """Publish two calibrations of a camera and the consensus that rests on them; return its mode."""
    documents = [calibration(camera, n) for n in range(2)]
    for document in documents:
        store(stack).calibrations.publish(document)
    store(stack).refit.now(asked(mode_of(documents[0]), "rectilinear"))
    return mode_of(documents[0])


def counted(capsys: pytest.CaptureFixture[str]) -> int:
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines() if line.startswith('{"_aws"')]
    return sum(line.get("DeniedReads", 0) for line in lines)


def in_turn(reads: int) -> Iterator[Callable[[int], bool]]:
    """Denials: of each read alone, and of each and all that follow."""
    for n in range(reads):
        yield lambda number, n=n: number == n
        yield lambda number, n=n: number >= n


def test_refit_of_denied_reads_stores_nothing(stack: LocalStack, capsys: pytest.CaptureFixture[str]) -> None:
    mode = known(stack, "Denied")
    store(stack).calibrations.publish(calibration("Denied", 2))
    before = store(stack).consensuses.at(mode)
    assert [c.total for c in before] == [2]
    counted(capsys)
    denials = [(which, False) for which in in_turn(3)] + [(lambda _: True, True)]
    for which, listing in denials:
        with faults.denied(which, listing=listing) as met, pytest.raises(UnavailableError):
            store(stack).refit.now(asked(mode, "rectilinear"))
        assert met
        assert store(stack).consensuses.at(mode) == before
    assert counted(capsys) == len(denials)
    (after,) = store(stack).refit.now(asked(mode, "rectilinear")).models.values()
    assert after is not None
    assert (after.total, after.reliable) == (3, True)


def test_refit_of_a_lost_object_stores_nothing(stack: LocalStack) -> None:
    """The index names a calibration that the bucket does not hold: nobody knows what it said."""
    mode = known(stack, "Lost")
    store(stack).calibrations.index(calibration("Lost", 2))
    before = store(stack).consensuses.at(mode)
    with pytest.raises(UnavailableError):
        store(stack).refit.now(asked(mode, "rectilinear"))
    assert store(stack).consensuses.at(mode) == before


def test_queued_refit_heals_by_itself(stack: LocalStack) -> None:
    mode = known(stack, "Queued")
    store(stack).calibrations.publish(calibration("Queued", 2))
    before = store(stack).consensuses.at(mode)
    failed = len(stack.failures())
    with faults.denied(lambda _: True):
        store(stack).refit.later(asked(mode))
        stack.wait_until_idle(60)
    assert store(stack).consensuses.at(mode) == before
    (record,) = stack.failures()[failed:]
    assert record["responsePayload"]["errorType"] == "DeniedReadError"
    # The queue of failures hands it to the function again, later.
    stack.functions["RefitFunction"]({"Records": [{"body": json.dumps(record)}]})
    assert {c.total for c in store(stack).consensuses.at(mode)} == {3}


def test_lookup_that_needs_a_denied_read_is_unavailable(stack: LocalStack) -> None:
    mode = known(stack, "Looked up")
    before = store(stack).consensuses.at(mode)

    def look() -> Answer:
        return Client(stack).lookup(camera="Looked up", platform=PLATFORM, distortion_model="fisheye")

    for which in in_turn(2):
        with faults.denied(which):
            refused(look())
        assert store(stack).consensuses.at(mode) == before
    assert look().status == 200


def test_export_of_a_denied_calibration_is_unavailable(
    stack: LocalStack, capsys: pytest.CaptureFixture[str]
) -> None:
    there, withdrawn = (calibration("Exported", n) for n in range(2))
    for document in (there, withdrawn):
        store(stack).calibrations.publish(document)
    store(stack).calibrations.withdraw(withdrawn, "wrong: mirrored", 0)

    def export(identity: str) -> Answer:
        return Client(stack).call("GET", f"/v1/calibrations/{identity}", token=TOKEN)

    missing = there.id[:-1] + ("0" if there.id[-1] != "0" else "1")
    # By number of the read denied, with the list of the bucket and without it: the document, the tombstone.
    # The list tells that there is nothing to deny.
    expected = {
        there.id: (200, {0: (503, 503), 1: (200, 503)}),
        withdrawn.id: (410, {0: (503, 503), 1: (503, 503)}),
        missing: (404, {0: (404, 503)}),
    }
    for identity, (status, by_read) in expected.items():
        for denied, answers in by_read.items():
            for listing, answer in zip((False, True), answers, strict=True):
                with faults.denied(lambda number, n=denied: number == n, listing=listing):
                    assert export(identity).status == answer, (identity, denied, listing)
        assert export(identity).status == status
    counted(capsys)
    with faults.denied(lambda number: number == 1):  # the tombstone, in whose absence it would be shown
        refused(export(withdrawn.id))
    assert counted(capsys) == 1


def test_check_whose_reads_are_denied_is_unavailable(stack: LocalStack) -> None:
    mode = known(stack, "Checked")
    client = Client(stack)
    client.authenticate()
    body = {**CAMERA, "camera": "Checked", "platform": PLATFORM, "views": VIEWS}
    before = store(stack).consensuses.at(mode)
    with faults.denied(lambda _: True) as met:
        refused(client.call("POST", "/v1/checks", body))
        stack.wait_until_idle(60)
    assert met
    for which in (0, 1):  # of the computation that it waits for, or of the one that is queued
        with faults.denied(lambda number, n=which: number == n):
            assert client.call("POST", "/v1/checks", body).status in (200, 503)
            stack.wait_until_idle(60)
    stored = {c.distortion_model: c.calibration for c in store(stack).consensuses.at(mode)}
    assert stored["rectilinear"] == before[0].calibration
    answer = client.call("POST", "/v1/checks", body)
    assert (answer.status, answer.json["votes"]) == (200, {"agree": 1, "disagree": 0})


def refused(answer: Answer) -> None:
    assert (answer.status, answer.headers["retry-after"]) == (503, "1"), answer
