"""A lookup among a hundred thousand cameras, against the same one among none."""

import statistics
import time
from collections.abc import Callable, Iterator

from calibdb.schema import GroupsDocument
from calibdb.settings import Settings
from calibdb.store import Store
from calibdb.store.ports import IF_NOT_EXISTS, Item
from infra.server.server import Server
from tests.bench.table import Row, p50
from tests.helpers.service.client import Client
from tests.helpers.service.known import C920, LINUX, calibration, consensus

CAMERAS = 100_000


def rows() -> Iterator[Row]:
    with Server() as stack:
        lookup = one_known(stack)
        yield Row("lookup handler, p50", p50(lookup, repeat=200), 5, "ms", "gateway included")
        before = cpu(lookup)
        yield Row("lookup handler, processor time", before, None, "ms")
        missed = cpu(one_unknown(stack))
        yield Row("a lookup that misses, with its estimate, to it", missed / before, 1.1, "x")
        crowd(stack, CAMERAS)
        after = cpu(lookup)
        yield Row(f"the same among {CAMERAS:,} cameras", after / before, 1.2, "x")


def one_known(stack: Server) -> Callable[[], object]:
    """Publish a consensus, and return a lookup of its camera."""
    store = Store.of(Settings.from_environment(stack.environment))
    store.calibrations.publish(calibration())
    store.consensuses.put(consensus(), GroupsDocument(pooled=""), None)
    client = Client(stack)

    def lookup() -> None:
        answer = client.lookup(camera=C920, platform=LINUX)
        if answer.status != 200:
            raise RuntimeError(answer.body.decode())

    return lookup


def one_unknown(stack: Server) -> Callable[[], object]:
    """Return a lookup of a camera without calibrations, whose estimate is published."""
    client = Client(stack)

    def lookup() -> None:
        answer = client.lookup(camera="Logitech C270 (046d:0825)", platform=LINUX, miss="ok")
        if answer.json["estimate"]["basis"] != "published":
            raise RuntimeError(answer.body.decode())

    return lookup


def crowd(stack: Server, count: int) -> None:
    """Put cameras into the table, each with a consensus and a name."""
    document = consensus(camera="Another").model_dump_json()
    for first in range(0, count, 5_000):
        items: list[Item] = []
        for n in range(first, min(first + 5_000, count)):
            key = f"c4-another-{n:012x}"
            sk = "CONSENSUS#1280x720#0#rectilinear"
            items.append({"pk": f"CAMERA#{key}", "sk": sk, "basis": "", "document": document})
            items.append({"pk": "CAMERAS#", "sk": key, "name": "another"})
        assert stack.storage.table.put_transaction(items, IF_NOT_EXISTS)


def cpu(action: Callable[[], object]) -> float:
    """Processor time of `action`, ms: the first tenth of many: other work only adds to it."""
    times = []
    for _ in range(1000):
        start = time.process_time()
        action()
        times.append((time.process_time() - start) * 1e3)
    return statistics.quantiles(times, n=10)[0]
