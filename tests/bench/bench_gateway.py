"""The server under load: lookups that hit, over sockets, from another process."""

from collections.abc import Iterator
from urllib.parse import urlencode

from tests.bench.load import LABEL, drive, serving_known_camera
from tests.bench.table import Row
from tests.helpers.service.client import CAMERA, TOKEN

REQUESTS = 2000
RATE = 150  # lookups a second


def rows() -> Iterator[Row]:
    asked = {**CAMERA, "camera": LABEL, "img_size": "1280x720", "key": TOKEN}
    lookup = f"/v1/lookup?{urlencode(asked)}"
    with serving_known_camera() as server:
        yield Row("second start, until healthy", server.start_seconds, 2, "s")
        drive(server.url, "GET", lookup, requests=200, clients=4)
        alone = drive(server.url, "GET", lookup, requests=REQUESTS // 4, clients=1)
        paced = drive(server.url, "GET", lookup, requests=REQUESTS, clients=8, rate=RATE)
        most = drive(server.url, "GET", lookup, requests=REQUESTS, clients=8)
        health = drive(server.url, "GET", "/healthz", requests=REQUESTS, clients=8)
    yield Row("lookup over a socket, 1 client, p50", alone.percentile(0.5), None, "ms")
    yield Row(f"lookups over sockets, {RATE} a second, p99", paced.percentile(0.99), 50, "ms")
    note = f"{1e3 / most.each:.0f}/s"
    yield Row("lookups over sockets, saturated, each", most.each, 1e3 / RATE, "ms", note)
    note = f"{1e3 / health.each:.0f}/s"
    yield Row("health over sockets, saturated, each", health.each, None, "ms", note)
