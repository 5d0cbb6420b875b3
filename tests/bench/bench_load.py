"""Memory after many requests, and many captures at once. `make bench DOCS=load` and `DOCS=memory` do more."""

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

from infra.server.server import Server
from tests.bench import load
from tests.bench.memory import memory_mb, send_all_kinds
from tests.bench.table import Row
from tests.helpers.service.client import Client, Truth

REQUESTS, WARM = 10_000, 2_000
GUIDED = 32


def rows() -> Iterator[Row]:
    yield memory()
    yield guided()


def memory() -> Row:
    """Growth of the server over the requests after the first."""
    sizes = []
    with load.serving_known_camera() as server:
        for count in (WARM, REQUESTS - WARM):
            send_all_kinds(server.url, count)
            time.sleep(1)
            sizes.append(memory_mb(server.process.pid))
    before, after = sizes
    note = f"{after:.0f} MB after {REQUESTS} requests, {before:.0f} after {WARM}"
    return Row("memory of the server, growth", after - before, 4, "MB", note)


def guided() -> Row:
    """Captures that fail, of as many as are guided at once; the slowest says how long one takes then."""
    failed = 0
    taken = []

    def capture(seed: int) -> float:
        start = time.perf_counter()
        Truth(seed=seed).calibrate(Client(stack), camera=f"Camera {seed % 4}")
        return time.perf_counter() - start

    with Server() as stack, ThreadPoolExecutor(GUIDED) as users:
        for future in [users.submit(capture, seed) for seed in range(GUIDED)]:
            if (error := future.exception()) is None:
                taken.append(future.result())
            else:
                failed += 1
                print(error)
    note = f"the slowest took {max(taken, default=0):.1f} s"
    return Row(f"{GUIDED} guided captures at once, failed", failed, 0, "captures", note)
