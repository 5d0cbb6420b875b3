"""Load test: many captures at once against a running stack, over a failing connection.

`python -m tests.bench.captures URL`. Some requests are cut off half way, sent without waiting for a response,
or sent twice at once; like a page that lost its network, the client then asks again.
"""

import argparse
import http.client
import json
import queue
import random
import sys
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

import httpx
import numpy as np

from infra.console import track
from infra.deploy.smoke_capture import CallError, CaptureRecord, call, capture

FAULT_RATE = 0.2  # share of the requests
_TIMEOUT_S = 60.0  # s for one response


@dataclass(frozen=True)
class Outcome:
    """Acknowledged captures, faults and latencies of a load test."""

    heard: list[CaptureRecord]
    counts: Counter[str]
    latencies: list[float]  # ms
    seconds: float

    def lines(self) -> Iterator[str]:
        median, late = np.quantile(self.latencies, (0.5, 0.95))
        faults = ", ".join(f"{n} {name}" for name, n in sorted(self.counts.items()) if name != "requests")
        yield f"{len(self.heard)} captures in {self.seconds:.0f} s"
        yield f"{self.counts['requests']} requests, of these {faults or 'all on a good line'}"
        yield f"responses after {median:.0f} ms (median), {late:.0f} ms (95 %)"


@dataclass
class Line:
    """The connections of one client, which fail in a share `faults` of its requests."""

    url: str
    rng: random.Random
    faults: float
    counts: Counter[str] = field(default_factory=Counter)
    latencies: list[float] = field(default_factory=list)

    def call(self, method: str, path: str, credential: str, body: object = None) -> Any:
        """Ask until there is a response; raises CallError if it is not one of success."""
        self.counts["requests"] += 1
        if self.rng.random() < self.faults:
            fault = self.rng.choice(("cut off", "unheard", "twice"))
            self.counts[fault] += 1
            if fault == "twice":
                with ThreadPoolExecutor(2) as both:
                    one, _ = both.map(lambda _: call(self._ask, method, path, credential, body), range(2))
                    return one
            content = json.dumps(body).encode() if body is not None else b""
            self._drop(method, path, credential, content, whole=fault == "unheard")
        return call(self._ask, method, path, credential, body)

    def _connection(self) -> http.client.HTTPConnection:
        parts = urlsplit(self.url)
        kind = http.client.HTTPSConnection if parts.scheme == "https" else http.client.HTTPConnection
        return kind(parts.netloc, timeout=_TIMEOUT_S)

    def _ask(
        self, method: str, path: str, headers: Mapping[str, str], content: bytes | None
    ) -> httpx.Response:
        connection = self._connection()
        start = time.perf_counter()
        try:
            connection.request(method, path, content, dict(headers))
            answer = connection.getresponse()
            response = httpx.Response(answer.status, content=answer.read())
        finally:
            connection.close()
        self.latencies.append((time.perf_counter() - start) * 1e3)
        if response.status_code == HTTPStatus.SERVICE_UNAVAILABLE:
            self.counts["asked again"] += 1
        return response

    def _drop(self, method: str, path: str, credential: str, content: bytes, *, whole: bool) -> None:
        connection = self._connection()
        connection.connect()
        head = (
            f"{method} {path} HTTP/1.1\r\nHost: {connection.host}\r\nAuthorization: Bearer {credential}\r\n"
        )
        sent = f"{head}Content-Length: {len(content)}\r\n\r\n".encode() + content
        connection.sock.sendall(sent if whole else sent[: len(sent) // 2])
        connection.close()


def drive(
    url: str,
    token: str,
    sessions: int,
    clients: int,
    *,
    cameras: int = 16,
    finished: float = 1.0,
    faults: float = FAULT_RATE,
    seed: int = 0,
) -> Outcome:
    """Run captures from many clients at once, of cameras each of which has the same optics in all captures.

    `finished`: share of the captures that continue to their end; the others end after one view. `faults`:
    share of the requests whose connection fails. Equal seeds send equal views.

    Raises CallError if a response is an error, or a session has other views than were acknowledged.
    """
    lines = [Line(url, random.Random(f"{seed}/{n}"), faults) for n in range(clients)]
    ended: queue.SimpleQueue[None] = queue.SimpleQueue()

    def client(n: int) -> list[CaptureRecord]:
        heard = []
        try:
            for k in range(n, sessions, clients):
                camera, finish = f"Load camera {k % cameras:03d}", lines[n].rng.random() < finished
                heard.append(capture(lines[n].call, token, seed + k, camera, finish=finish))
                ended.put(None)
        finally:  # a client that broke off must not be waited for
            for _ in range(len(range(n, sessions, clients)) - len(heard)):
                ended.put(None)
        return heard

    start = time.perf_counter()
    with ThreadPoolExecutor(clients) as pool:
        running = [pool.submit(client, n) for n in range(clients)]
        for _ in track(range(sessions), "captures", sessions):
            ended.get()
        heard = [capture for each in running for capture in each.result()]
    return Outcome(
        heard,
        sum((line.counts for line in lines), Counter()),
        [latency for line in lines for latency in line.latencies],
        time.perf_counter() - start,
    )


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser("python -m tests.bench.captures", description="Many captures at once.")
    parser.add_argument("url", help="of the API, without /v1: http://127.0.0.1:8000")
    parser.add_argument("--token", default="cdb_dev_local")
    parser.add_argument("--sessions", type=int, default=200)
    parser.add_argument("--clients", type=int, default=64)
    options = parser.parse_args(arguments)
    try:
        outcome = drive(options.url.rstrip("/"), options.token, options.sessions, options.clients)
    except (CallError, OSError) as error:
        print(f"calibDB: {error}", file=sys.stderr)
        return 1
    print("\n".join(outcome.lines()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
