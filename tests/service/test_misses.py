"""Lookups that found nothing are counted by camera, written down now and then, and by nobody's words."""

from collections.abc import Iterator

import pytest

from calibdb.lookup.reports import MAX_CAMERAS, REPORT_S, MissCounter
from infra.server.server import Server
from tests.helpers.clock import Clock
from tests.helpers.service.client import Client
from tests.helpers.service.index_items import items
from tests.helpers.service.known import C920, LINUX, calibration, consensus
from tests.helpers.service.published import put, store
from tests.helpers.service.stores import override_service


@pytest.fixture
def clock() -> Iterator[Clock]:
    clock = Clock(1_800_000_000)
    with override_service(clock=clock):
        yield clock


def test_misses_are_counted_by_camera_and_written_later(clock: Clock) -> None:
    with Server(environment={"MIN_CONTRIBUTORS": "3"}) as stack:
        known = calibration(C920, LINUX)
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
        assert written() == {f"CAMERA#{known.camera_key}": 1}, "an instance may not live long"
        ask(*[C920] * 2, "Cheap drugs (046d:0825)", "Buy it now! 12", "Integrated Camera")
        assert written() == {f"CAMERA#{known.camera_key}": 1}, "few lookups write"
        clock.now += REPORT_S + 1
        ask(C920)
        assert written() == {f"CAMERA#{known.camera_key}": 4, "CAMERA#usb#046d:0825": 1}
        assert store(stack).miss_counts.most(int(clock())) == [(known.camera_key, 4), ("usb#046d:0825", 1)]
        assert store(stack).miss_counts.most(int(clock()) + 92 * 86_400) == []


def test_miss_counter_is_bounded() -> None:
    counter = MissCounter()
    assert counter.count("usb#046d:0000", 0.0) == {"usb#046d:0000": 1}, "the first is reported at once"
    for n in range(3 * MAX_CAMERAS):
        assert counter.count(f"usb#046d:{n:04x}", 1.0) == {}
    reported = counter.count("usb#046d:0000", REPORT_S)
    assert (len(reported), reported["usb#046d:0000"]) == (MAX_CAMERAS, 2)
    assert counter.count("usb#046d:0000", REPORT_S + 1) == {}
