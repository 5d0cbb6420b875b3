"""The local stack under load: lookups that hit, over sockets, from another process."""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlencode

from infra.local import LocalStack
from tests.bench.load import drive
from tests.bench.table import Row
from tests.client import CAMERA, TOKEN, Client, Truth
from tests.processes import LocalProcess

REQUESTS = 2000


def rows() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as place:
        data_dir = Path(place, "data")
        with LocalStack(data_dir) as stack:
            for seed in range(5):
                Truth(seed=seed).calibrate(Client(stack))
        asked = {**CAMERA, "img_size": "1280x720", "key": TOKEN}
        lookup = f"/v1/lookup?{urlencode(asked)}"
        with LocalProcess(data_dir) as server:
            yield Row("second start, until healthy", server.start_seconds, 5, "s")
            drive(server.url, lookup, 200, 4)
            one, eight = (drive(server.url, lookup, REQUESTS, clients) for clients in (1, 8))
            health = drive(server.url, "/healthz", REQUESTS, 8)
    yield Row("lookup over a socket, 1 client, p50", one.percentile(0.5), None, "ms")
    # 150 lookups a second.
    yield Row(
        "lookup over sockets, 8 clients, each", eight.each, 1000 / 150, "ms", f"{1e3 / eight.each:.0f}/s"
    )
    yield Row("lookup over sockets, 8 clients, p99", eight.percentile(0.99), 50, "ms")
    yield Row("health over sockets, 8 clients, each", health.each, None, "ms", f"{1e3 / health.each:.0f}/s")
