"""Memory and files after many requests, and many captures at once. `make bench DOCS=load` does more."""

import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx

from infra.server.server import Server
from tests.bench.memory import memory_mb
from tests.bench.table import Row
from tests.helpers.service.client import CAMERA, TOKEN, Client, Truth
from tests.helpers.stack.processes import LocalProcess

REQUESTS, WARM = 10_000, 2_000
GUIDED = 32


def rows() -> Iterator[Row]:
    yield memory()
    yield guided()


def memory() -> Row:
    """Growth of the server over the requests after the first, of every kind that leaves nothing behind."""
    with tempfile.TemporaryDirectory() as folder, LocalProcess(Path(folder) / "data") as server:
        client = httpx.Client(base_url=server.url)

        def ask(method: str, path: str, credential: str, body: object) -> Any:
            response = client.request(
                method, path, json=body, headers={"Authorization": f"Bearer {credential}"}
            )
            if response.status_code >= 500:
                raise RuntimeError(f"{method} {path}: {response.status_code}")
            return response.json()

        session = ask("POST", "/v1/auth", TOKEN, None)["session_id"]
        ask("POST", "/v1/session", session, CAMERA)
        truth = Truth()
        ids, points = truth.see({"rvec": [0.5, 0, 0], "tvec": [-4.5, -3, 9]})
        ask("POST", "/v1/session/views", session, {"index": 0, "ids": ids, "points": points})
        lookup = {**CAMERA, "redirect": False}
        kinds: tuple[tuple[str, str, str, object], ...] = (
            ("POST", "/v1/lookup", TOKEN, lookup),
            ("GET", "/v1/session", session, None),
            ("POST", "/v1/auth", TOKEN, None),
            ("GET", "/v1/cameras?query=test", TOKEN, None),
            ("POST", "/v1/lookup", TOKEN, {**lookup, "camera": "Another camera"}),
            ("GET", "/healthz", "", None),
        )
        sizes = {}
        for number in range(1, REQUESTS + 1):
            ask(*kinds[number % len(kinds)])
            if number in (WARM, REQUESTS):
                time.sleep(1)
                sizes[number] = memory_mb(server.process.pid)
    note = f"{sizes[REQUESTS]:.0f} MB after {REQUESTS} requests, {sizes[WARM]:.0f} after {WARM}"
    return Row("memory of the server, growth", sizes[REQUESTS] - sizes[WARM], 4, "MB", note)


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
