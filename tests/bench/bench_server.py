"""The server under load: lookups of a known camera, and requests/s against an empty application."""

import os
import statistics
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from tests.bench.load import HEALTH, KNOWN, Request, drive, page, serving_known_camera
from tests.bench.table import Row
from tests.helpers.data import ROOT

REQUESTS = 2000
RATE = 150  # lookups/s
WORKERS, ROUNDS = 2, 5
EMPTY = """
import os, socket
from starlette.applications import Starlette
from starlette.responses import Response
from starlette.routing import Route
from infra.server.server import bind, http_server

async def empty(request):
    return Response(b"")

listener = bind("127.0.0.1", 0)
print(f"http://127.0.0.1:{listener.getsockname()[1]}", flush=True)
for _ in range(1, WORKERS):
    if os.fork() == 0:
        break
http_server(Starlette(routes=[Route("/", empty)])).run([listener])
"""


def rows() -> Iterator[Row]:
    yield from lookups()
    yield from shares()


def lookups() -> Iterator[Row]:
    """Latencies of one process."""
    with serving_known_camera() as server:
        yield Row("second start, until healthy", server.start_seconds, 2, "s")
        drive(server.url, KNOWN, requests=200, clients=4)
        alone = drive(server.url, KNOWN, requests=REQUESTS // 4, clients=1)
        paced = drive(server.url, KNOWN, requests=REQUESTS, clients=8, rate=RATE)
        most = drive(server.url, KNOWN, requests=REQUESTS, clients=8)
    yield Row("lookup over a socket, 1 client, p50", float(np.median(alone.latencies)), None, "ms")
    p99 = float(np.quantile(paced.latencies, 0.99))
    yield Row(f"lookups over sockets, {RATE} a second, p99", p99, 50, "ms")
    note = f"{1e3 / most.each:.0f}/s"
    yield Row("lookups over sockets, saturated, each", most.each, 1e3 / RATE, "ms", note)


def shares() -> Iterator[Row]:
    """Requests/s of two processes, against an empty application under the same uvicorn options."""
    with empty_server() as empty, serving_known_camera(WORKERS=str(WORKERS)) as server:
        for what, least, request in (
            ("POST lookup of a known camera", 0.10, KNOWN),
            ("landing page", 0.25, page("/")),
            ("/healthz", 0.5, HEALTH),
        ):
            rate(server.url, request)  # warm
            pairs = [(rate(server.url, request), rate(empty, ("GET", "/", {}, ""))) for _ in range(ROUNDS)]
            ours, theirs = (statistics.median(column) for column in zip(*pairs, strict=True))
            note = f"{ours:.0f} of {theirs:.0f}/s, share {ours / theirs:.3f}, at least {least}"
            yield Row(f"requests of an empty app per {what}", theirs / ours, 1 / least, "", note)


def rate(url: str, request: Request) -> float:
    return 1e3 / drive(url, request, requests=2 * REQUESTS, clients=8).each


@contextmanager
def empty_server() -> Iterator[str]:
    """Run an empty Starlette application in `WORKERS` processes; yield its address."""
    process = subprocess.Popen(
        [sys.executable, "-c", f"WORKERS = {WORKERS}\n{EMPTY}"],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    try:
        assert process.stdout
        yield process.stdout.readline().strip()
    finally:
        os.killpg(process.pid, 9)
        process.wait()
