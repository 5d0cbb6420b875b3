"""The server under load: lookups that hit, over sockets, from another process."""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import urlencode

from infra.server.server import Server
from tests.bench.load import drive
from tests.bench.table import Row
from tests.helpers.service.client import CAMERA, TOKEN, Client, Truth, until
from tests.helpers.service.published import store
from tests.helpers.stack.processes import LocalProcess

REQUESTS = 2000
RATE = 150  # lookups a second


def rows() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as place:
        data_dir = Path(place, "data")
        with Server(data_dir) as stack:
            done = [Truth(seed=seed).calibrate(Client(stack)) for seed in range(5)]
            key = done[-1]["calibration_id"].rpartition("-")[0]
            # What is still to be computed would be taken up again by the server, beside the lookups.
            until(lambda: [c.total for c in store(stack).consensuses.of(key)] == 4 * [5], 120)
        asked = {**CAMERA, "img_size": "1280x720", "key": TOKEN}
        lookup = f"/v1/lookup?{urlencode(asked)}"
        with LocalProcess(data_dir) as server:
            yield Row("second start, until healthy", server.start_seconds, 2, "s")
            drive(server.url, lookup, 200, 4)
            alone = drive(server.url, lookup, REQUESTS // 4, 1)
            paced = drive(server.url, lookup, REQUESTS, 8, rate=RATE)
            most = drive(server.url, lookup, REQUESTS, 8)
            health = drive(server.url, "/healthz", REQUESTS, 8)
    yield Row("lookup over a socket, 1 client, p50", alone.percentile(0.5), None, "ms")
    yield Row(f"lookups over sockets, {RATE} a second, p99", paced.percentile(0.99), 50, "ms")
    note = f"{1e3 / most.each:.0f}/s"
    yield Row("lookups over sockets, saturated, each", most.each, 1e3 / RATE, "ms", note)
    note = f"{1e3 / health.each:.0f}/s"
    yield Row("health over sockets, saturated, each", health.each, None, "ms", note)
