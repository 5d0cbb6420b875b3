"""The weekly dump."""

import gzip
import hashlib
import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from calibdb.dump import weekly_dump
from calibdb.dump.figures import Figures
from calibdb.dump.weekly_dump import PERIOD_S, WeeklyDump
from calibdb.errors import UnavailableError
from calibdb.schema import CalibrationDocument
from calibdb.schema.dump import Dump
from calibdb.store import Store
from calibdb.store.dumps import Dumps
from calibdb.store.miss_counts import USB
from calibdb.store.ports import Storage
from infra.ops import withdrawal
from infra.ops.context import OpsContext
from infra.ops.public_dump import publish_dump
from infra.server.server import Server
from infra.web_build import openapi
from tests.helpers.service import published
from tests.helpers.service.intercepted import crash_after
from tests.helpers.service.known import C920, LINUX, calibration, consensus, vote
from tests.helpers.service.published import put

NOW = 1_795_312_800  # a Sunday
GIVEN = {"licence": "CC0-1.0", "licence_version": "2026-11-22"}
SCHEMA = json.loads(openapi.dump_schema())


@pytest.fixture
def stack() -> Iterator[Server]:
    with Server() as stack:
        yield stack


@pytest.fixture
def store(stack: Server) -> Store:
    return published.store(stack)


@pytest.fixture
def context(stack: Server) -> OpsContext:
    return OpsContext.of(stack.environment, secret_known=True)


def fill(
    store: Store, count: int, given: Callable[[int], bool] = lambda _: True
) -> list[CalibrationDocument]:
    made = []
    for n in range(count):
        label = (C920, "Microsoft LifeCam HD-3000 (045e:0779)", "Anna's Webcam Z77")[n % 3]
        document = calibration(label, f"{LINUX}; Anna", number=n)
        document = document.model_copy(update=GIVEN if given(n) else {})
        store.calibrations.publish(document)
        if n % 7 == 6:
            store.calibrations.withdraw(document, "wrong", NOW)
        made.append(document)
    return made


def writer(storage: Storage, now: int = NOW, left: Callable[[], float] = lambda: 900.0) -> WeeklyDump:
    dumps, store = Dumps(storage.objects, storage.site), Store.over(storage)
    figures = Figures(dumps, store.cameras, store.miss_counts, store.calibrations, 3)
    return WeeklyDump(dumps, figures, lambda: now, left)


def read(stack: Server, name: str) -> bytes | None:
    return stack.storage.site.get(f"dumps/{name}")


def latest(stack: Server) -> Dump:
    return Dump.model_validate_json(read(stack, "latest.json"))


def statistics_of(stack: Server) -> Any:
    return json.loads(read(stack, "statistics.json"))


def documents(stack: Server, dump: Dump, kind: str) -> list[dict[str, Any]]:
    found = []
    for file in dump.files:
        content = read(stack, file.name)
        assert (len(content), hashlib.sha256(content).hexdigest()) == (file.size, file.sha256)
        lines = gzip.decompress(content).splitlines()
        assert len(lines) == file.count
        found += [json.loads(line) for line in lines] if file.kind == kind else []
    return found


def test_dump_holds_what_was_given_and_names_nobody(stack: Server, context: OpsContext) -> None:
    made = fill(context.store, 20, given=lambda n: n % 2 == 0)
    context.store.votes.cast(vote(made[0], **GIVEN))
    context.store.votes.cast(vote(made[1]))
    dump = publish_dump(context)
    expected = {d.id for n, d in enumerate(made) if n % 2 == 0 and n % 7 != 6}
    found = documents(stack, dump, "calibrations")
    assert {one["id"] for one in found} == expected
    votes = documents(stack, dump, "votes")
    assert len(votes) == 1
    assert dump.counts.model_dump() == {"calibrations": 9, "votes": 1, "cameras": 3, "contributors": 9}
    assert {(one["licence"], one["licence_version"]) for one in (*found, *votes)} == {tuple(GIVEN.values())}
    everything = json.dumps([found, votes])
    assert not [word for word in ("Anna", "contributor 0", "127.0.0.1") if word in everything]
    statistics = statistics_of(stack)
    assert latest(stack) == dump
    # All of it as the schema says, which the page links.
    for value, model in (
        (json.loads(read(stack, "latest.json")), "Dump"),
        (statistics, "Statistics"),
        (found[0], "CalibrationDocument"),
        (votes[0], "VoteDocument"),
    ):
        Draft202012Validator({**SCHEMA, "$ref": f"#/$defs/{model}"}).validate(value)
    (snapshot,) = statistics["history"]
    counts = [snapshot[name] for name in ("calibrations", "cameras", "contributors", "given")]
    assert counts == [18, 3, 18, 9]
    other = documents(stack, publish_dump(context), "calibrations")
    assert {one["contributor"] for one in found}.isdisjoint(one["contributor"] for one in other)


def test_dump_survives_a_crash_at_every_write(
    stack: Server, store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Small parts, and an end after one to three writes: `latest.json` names a whole dump throughout."""
    fill(store, 12)
    assert writer(stack.storage).run() is not None
    monkeypatch.setattr(weekly_dump, "MAX_PART_BYTES", 1000)
    later = NOW + PERIOD_S
    crashes = 0
    for at in range(60):
        with crash_after(stack.storage, 1 + at % 3) as storage:
            try:
                writer(storage, later).run()
            except UnavailableError:
                crashes += 1
        named = latest(stack)
        assert named.created in (NOW, later)
        ids = [one["id"] for one in documents(stack, named, "calibrations")]
        assert len(ids) == len(set(ids)) == 11
        if named.created == later:
            break
    assert crashes >= 5
    assert (named.created, len(named.files) >= 5) == (later, True)
    # What is left of it is thrown away with the next call, and the key with it.
    writer(stack.storage, later).run()
    assert writer(stack.storage, later).dumps.draft() is None
    assert statistics_of(stack)["history"][-1]["calibrations"] == 11


def test_dump_stops_when_its_time_is_up_and_goes_on(stack: Server, store: Store) -> None:
    fill(store, 8)
    runs = 0
    while (dump := writer(stack.storage, left=lambda: 1.0).run()) is None:
        runs += 1
        assert read(stack, "latest.json") is None
        assert runs < 100
    assert runs >= 4
    assert len(documents(stack, dump, "calibrations")) == 7
    assert writer(stack.storage, NOW + 3600).run() is None, "none is due"
    assert writer(stack.storage, NOW + PERIOD_S).run() is not None


def test_two_writers_make_one_dump(stack: Server, store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """The one that was overtaken while it wrote a part stops; no part is named that another replaced."""
    fill(store, 12)
    monkeypatch.setattr(weekly_dump, "MAX_PART_BYTES", 1000)
    slow = writer(stack.storage)
    original, overtaken = slow.dumps.advance, []

    def advance(draft: Any, tag: str) -> str | None:
        if not overtaken:
            monkeypatch.setattr(weekly_dump, "MAX_PART_BYTES", 2000)
            overtaken.append(writer(stack.storage).run())
        return original(draft, tag)

    slow.dumps.advance = advance
    assert slow.run() is None
    assert overtaken == [latest(stack)]
    assert len({one["id"] for one in documents(stack, latest(stack), "calibrations")}) == 11


def test_wanted_cameras_are_named_by_no_strangers_words(stack: Server, store: Store) -> None:
    known, doubted, single = "Known (046d:0001)", "Doubted (046d:0002)", "Buy pills (046d:0003)"
    keys = {}
    for label, reason, calibrations in ((known, None, 5), (doubted, "disagree", 4), (single, "too_few", 1)):
        document = calibration(label)
        keys[label] = document.camera_key
        store.calibrations.publish(document)
        put(store, consensus(camera=label, platform=LINUX, reason=reason, calibrations=calibrations))
    store.miss_counts.add(
        {keys[known]: 9, keys[doubted]: 5, keys[single]: 90, USB + "046d:0825": 7, USB + "fffe:0001": 99}, NOW
    )
    store.miss_counts.add({keys[doubted]: 4, USB + "046d:0003": 50}, NOW - 80 * 86_400)
    store.miss_counts.add({keys[doubted]: 1000}, NOW - 100 * 86_400)
    writer(stack.storage).run()
    statistics = statistics_of(stack)
    named = [(one["camera"], one["key"], one["asked"]) for one in statistics["wanted"]]
    assert named == [(doubted, keys[doubted], 9), ("Logitech, Inc. (046d:0825)", None, 7)]
    assert "pills" not in json.dumps(statistics)
    assert statistics["history"][0]["known"] == 1


def test_forgetting_replaces_the_dumps(stack: Server, context: OpsContext) -> None:
    made = fill(context.store, 4)
    before = publish_dump(context)
    withdrawal.forget(context, {made[0].contributor})
    now = latest(stack)
    assert made[0].id not in {one["id"] for one in documents(stack, now, "calibrations")}
    assert now.counts.calibrations == 3
    for file in before.files:
        if file.count and file not in now.files:
            assert read(stack, file.name) is None


def test_bundle_of_known_cameras_says_its_licence(stack: Server, context: OpsContext) -> None:
    store = context.store
    given, mixed = C920, "Microsoft LifeCam HD-3000 (045e:0779)"
    for label in (given, mixed):
        for n in range(2):
            document = calibration(label, number=n)
            consented = label == given or n == 0
            store.calibrations.publish(document.model_copy(update=GIVEN if consented else {}))
        put(store, consensus(camera=label, platform=LINUX))
    publish_dump(context)
    entry = statistics_of(stack)["bundle"]
    content = read(stack, entry["name"])
    assert (len(content), hashlib.sha256(content).hexdigest()) == (entry["size"], entry["sha256"])
    bundle = json.loads(content)
    licences = {camera["camera"]: camera.get("licence") for camera in bundle["cameras"]}
    assert licences == {given: "CC0-1.0", mixed: None}
    assert set(bundle["labels"]) >= {given, "HD Pro Webcam C920", mixed}
