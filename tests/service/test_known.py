"""Known cameras by GET, and counts of lookups that found nothing."""

import json
from collections.abc import Iterator
from typing import Any

import pytest

from calibdb.camera_key import camera_key
from calibdb.lookup.reports import MAX_CAMERAS, REPORT_S, AliasFilter, MissCounter
from calibdb.store.aliases import (
    ALIAS_EXPIRY_S,
    ALIAS_RENEWAL_S,
    MAX_OF_CAMERA,
    MAX_OF_SOURCE,
    Alias,
    Aliases,
    alias_digest,
)
from calibdb.store.sqlite import Database, SqliteTable
from infra.server.server import Server
from tests.helpers.clock import Clock
from tests.helpers.service.client import Client
from tests.helpers.service.in_process import Response, request
from tests.helpers.service.index_items import items
from tests.helpers.service.known import C920, LINUX, consensus
from tests.helpers.service.published import PLATFORM, asked, calibration, mode_of, publish, put, store
from tests.helpers.service.storage_calls import storage_calls
from tests.helpers.service.stores import override_service

CAMERA = "Known by all (046d:0825)"
DIGEST = alias_digest(CAMERA, PLATFORM)
PATH = f"/known/v1/{DIGEST}/1280x720/0/rectilinear.json"
KNOWN_CACHE = "public, max-age=60, s-maxage=300, stale-while-revalidate=60, stale-if-error=86400"
MISS_CACHE = "public, max-age=60, s-maxage=60"
DAY_S = 86_400


@pytest.fixture(scope="module")
def stack() -> Iterator[Server]:
    with Server() as stack:
        publish(stack, *(calibration(CAMERA, n) for n in range(5)))
        yield stack


def get(stack: Server, path: str = PATH, **headers: str) -> Response:
    return request(stack, "GET", path, {name.replace("_", "-"): value for name, value in headers.items()})


def posted(stack: Server, camera: str = CAMERA, platform: str = PLATFORM) -> Any:
    answer = Client(stack).lookup(camera=camera, platform=platform)
    stack.wait_until_idle(60)
    return answer


def test_camera_is_known_by_get_once_a_post_found_it(stack: Server) -> None:
    unknown = get(stack)
    assert (unknown.status, json.loads(unknown.body)) == (404, {"reason": "unknown_camera"})
    assert unknown.headers["cache-control"] == MISS_CACHE
    answer = posted(stack)
    found = get(stack)
    assert (found.status, found.body) == (200, answer.body)
    for each in (found, unknown):
        assert each.headers["access-control-allow-origin"] == "*"
    assert found.headers["cache-control"] == KNOWN_CACHE
    same = get(stack, if_none_match=found.headers["etag"])
    assert (same.status, same.body, same.headers["etag"]) == (304, b"", found.headers["etag"])


def test_other_forms_of_an_address_are_unknown(stack: Server) -> None:
    posted(stack)
    for path in (
        PATH.replace("1280x720", "01280x720"),
        PATH.replace("rectilinear.json", "rectilinear"),
        PATH.replace("rectilinear", "none"),
        PATH.replace("/0/", "/0.0/"),
        PATH.replace("/0/", "/-0/"),
        PATH.replace(DIGEST, DIGEST.upper()),
        PATH.replace(DIGEST, "0" * 32),
    ):
        answer = get(stack, path)
        assert (answer.status, answer.headers["cache-control"]) == (404, MISS_CACHE), path
    assert request(stack, "POST", PATH).status == 405
    other = Client(stack).lookup(camera=CAMERA, platform=PLATFORM, img_size=[640, 360])
    assert get(stack, PATH.replace("1280x720", "640x360")).body == other.body


def test_lookup_reads_twice_and_writes_nothing(stack: Server) -> None:
    posted(stack)
    with storage_calls(stack) as calls:
        assert get(stack).status == 200
        assert calls == ["GetItem", "Query"]
        assert get(stack, PATH.replace(DIGEST, "1" * 32)).status == 404
        assert calls == ["GetItem", "Query", "GetItem"]


def test_withdrawn_camera_is_gone(stack: Server) -> None:
    label = "To be withdrawn (046d:0826)"
    documents = [calibration(label, n) for n in range(5)]
    publish(stack, *documents)
    posted(stack, label)
    path = f"/known/v1/{alias_digest(label, PLATFORM)}/1280x720/0/rectilinear.json"
    assert get(stack, path).status == 200
    for document in documents[:4]:
        store(stack).calibrations.withdraw(document, "wrong", 0)
    store(stack).refit.now(asked(mode_of(documents[0])))
    gone = get(stack, path)
    assert (gone.status, json.loads(gone.body)) == (404, {"reason": "too_few"})


def test_label_of_a_person_is_not_stored(stack: Server) -> None:
    label = "Anna's iPhone Camera"
    posted(stack, label)
    assert store(stack).aliases.get(alias_digest(label, PLATFORM)) is None


@pytest.fixture
def clock() -> list[int]:
    return [1_700_000_000]


@pytest.fixture
def aliases(clock: list[int]) -> Iterator[Aliases]:
    database = Database(None, lambda: clock[0])
    yield Aliases(SqliteTable(database))
    database.close()


def test_aliases_are_bounded_by_source_and_camera(aliases: Aliases, clock: list[int]) -> None:
    stored = [aliases.record(Alias(f"Label {n}", "Linux"), "c4-a", "source", clock[0]) for n in range(30)]
    assert stored == [True] * MAX_OF_SOURCE + [False] * 10
    assert aliases.record(Alias("Label 0", "Linux"), "c4-a", "source", clock[0]), "it is known"
    others = [
        aliases.record(Alias(f"Other {n}", "Linux"), "c4-a", f"source {n}", clock[0])
        for n in range(MAX_OF_CAMERA)
    ]
    assert others.count(True) == MAX_OF_CAMERA - MAX_OF_SOURCE
    assert aliases.record(Alias("Label", "Linux"), "c4-b", "another", clock[0])
    clock[0] += DAY_S
    assert aliases.record(Alias("Of the next day", "Linux"), "c4-b", "source", clock[0])


def test_alias_expires_180_days_after_its_last_use(aliases: Aliases, clock: list[int]) -> None:
    alias = Alias("Label", "Linux")
    assert aliases.record(alias, "c4-a", "source", clock[0])
    clock[0] += ALIAS_RENEWAL_S + 1
    assert not aliases.get(alias.digest).is_fresh(clock[0])
    assert aliases.record(alias, "c4-a", "source", clock[0])
    clock[0] += ALIAS_EXPIRY_S - 1
    assert aliases.get(alias.digest) is not None
    clock[0] += 1
    assert aliases.get(alias.digest) is None


def test_filter_looks_after_each_alias_once_a_day() -> None:
    seen = AliasFilter()
    times = (0, 1, DAY_S - 1, DAY_S, DAY_S)
    assert [seen.admit(("a", "b"), now) for now in times] == [True, False, False, True, False]
    assert seen.admit(("a", "c"), 0)


@pytest.fixture
def late() -> Iterator[Clock]:
    clock = Clock(1_800_000_000)
    with override_service(clock=clock):
        yield clock


def test_misses_are_counted_by_camera_and_written_later(late: Clock) -> None:
    with Server(environment={"MIN_CONTRIBUTORS": "3"}) as stack:
        key = camera_key(C920, LINUX)
        put(store(stack), consensus(camera=C920, platform=LINUX, reason="disagree", calibrations=4))
        client = Client(stack)

        def ask(*labels: str) -> None:
            for label in labels:
                answer = client.lookup(camera=label, platform=LINUX, redirect=False)
                assert answer.status == 404

        def written() -> dict[str, int]:
            stack.wait_until_idle(60)
            found = items(stack).items()
            return {sk: int(str(i["asked"])) for (pk, sk), i in found if pk.startswith("ASKED#")}

        ask(C920)
        assert written() == {f"CAMERA#{key}": 1}, "an instance may not live long"
        ask(*[C920] * 2, "Cheap drugs (046d:0825)", "Buy it now! 12", "Integrated Camera")
        assert written() == {f"CAMERA#{key}": 1}, "few lookups write"
        late.now += REPORT_S + 1
        ask(C920)
        assert written() == {f"CAMERA#{key}": 4, "CAMERA#usb#046d:0825": 1}
        assert store(stack).miss_counts.most(int(late())) == [(key, 4), ("usb#046d:0825", 1)]
        assert store(stack).miss_counts.most(int(late()) + 92 * 86_400) == []


def test_miss_counter_is_bounded() -> None:
    counter = MissCounter()
    assert counter.count("usb#046d:0000", 0.0) == {"usb#046d:0000": 1}, "the first is reported at once"
    for n in range(3 * MAX_CAMERAS):
        assert counter.count(f"usb#046d:{n:04x}", 1.0) == {}
    reported = counter.count("usb#046d:0000", REPORT_S)
    assert (len(reported), reported["usb#046d:0000"]) == (MAX_CAMERAS, 2)
    assert counter.count("usb#046d:0000", REPORT_S + 1) == {}
