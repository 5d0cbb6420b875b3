"""Requests per second with two workers, against an empty application under the same uvicorn options."""

import json
import os
import statistics
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from tests.bench.load import LABEL, ROOT, drive, serving_known_camera
from tests.bench.table import Row
from tests.helpers.service.client import CAMERA, TOKEN

WORKERS, CLIENTS, REQUESTS, ROUNDS = 2, 8, 4000, 5
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
    with empty_server() as empty, serving_known_camera(WORKERS=str(WORKERS)) as server:
        body = json.dumps({**CAMERA, "camera": LABEL})
        headers = {"authorization": f"Bearer {TOKEN}", "content-type": "application/json"}
        for what, least, request in (
            ("POST lookup of a known camera", 0.10, ("POST", "/v1/lookup", headers, body)),
            ("landing page", 0.25, ("GET", "/", {"accept-encoding": "gzip"}, "")),
            ("/healthz", 0.5, ("GET", "/healthz", {}, "")),
        ):
            rate(server.url, *request)  # warm
            pairs = [(rate(server.url, *request), rate(empty, "GET", "/", {}, "")) for _ in range(ROUNDS)]
            ours, theirs = (statistics.median(column) for column in zip(*pairs, strict=True))
            note = f"{ours:.0f} of {theirs:.0f}/s, share {ours / theirs:.3f}, at least {least}"
            yield Row(f"requests of an empty app per {what}", theirs / ours, 1 / least, "", note)


def rate(url: str, method: str, path: str, headers: dict[str, str], body: str) -> float:
    """Requests per second from `CLIENTS` connections."""
    return 1e3 / drive(url, method, path, headers, body, requests=REQUESTS, clients=CLIENTS).each


@contextmanager
def empty_server() -> Iterator[str]:
    """Run an empty Starlette application in `WORKERS` processes; yields its address."""
    process = subprocess.Popen(
        [sys.executable, "-c", f"WORKERS = {WORKERS}\n{EMPTY}"],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(("layers/service", "layers/solver", "."))},
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
