"""Load test: many captures at once against a running stack, over a failing connection.

`python -m infra.deploy.load_test`.

Each client opens sessions, submits views of a camera that does not exist, and looks it up. Some requests are
cut off half way, sent without waiting for an answer, or sent twice at once; like a page that lost its
network, the client then asks again. It returns the acknowledgements, to be compared with stored data.
"""

from __future__ import annotations

import argparse
import http.client
import json
import queue
import random
import socket
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

import numpy as np

from calibsolver import Board, Camera
from calibsolver import rotation as rotations
from infra.console import track

FAULT_RATE = 0.2  # share of the requests
_TIMEOUT_S = 60.0  # s for one answer
_MAX_BUSY_ATTEMPTS = 10  # where the stack says that it has no time
_TARGET_ERROR_PX = 100.0  # px: the fourth accepted view ends the capture
_NOISE_PX = 0.15  # px
_IMG_SIZE = (1280, 720)
# (rvec about x and y, rad) of a board that teaches something each time
_TILTS = ((0.5, 0.0), (-0.5, 0.1), (0.1, 0.55), (0.0, -0.6), (0.4, 0.4), (-0.4, -0.4), (0.45, -0.4))

View = tuple[int, list[int], list[list[float]]]  # index, ids, points


@dataclass
class CaptureRecord:
    """The views and the calibration of one capture that the server acknowledged."""

    views: list[View] = field(default_factory=list)
    calibration_id: str | None = None


@dataclass(frozen=True)
class Outcome:
    """Outcome of a load test: captures, faults and latencies."""

    heard: list[CaptureRecord]
    counts: Counter[str]
    latencies: list[float]  # ms, sorted
    seconds: float

    def percentile(self, share: float) -> float:
        """Compute the latency, ms, that this share of the requests stayed within."""
        return self.latencies[min(len(self.latencies) - 1, int(share * len(self.latencies)))]

    def lines(self) -> Iterator[str]:
        """Yield a summary, line by line."""
        faults = ", ".join(f"{n} {name}" for name, n in sorted(self.counts.items()) if name != "requests")
        yield f"{len(self.heard)} captures in {self.seconds:.0f} s"
        yield f"{self.counts['requests']} requests, of these {faults or 'all on a good line'}"
        yield f"responses after {self.percentile(0.5):.0f} ms (median), {self.percentile(0.95):.0f} ms (95 %)"


class LoadError(RuntimeError):
    """The stack did not do what it must."""


@dataclass
class Line:
    """The connections of one client, which fail in a share `faults` of its requests."""

    url: str
    rng: random.Random
    faults: float = FAULT_RATE
    counts: Counter[str] = field(default_factory=Counter)
    latencies: list[float] = field(default_factory=list)

    def call(self, method: str, path: str, credential: str, body: object = None) -> Any:
        """Ask until there is an answer; raises LoadError if it is not one of success."""
        self.counts["requests"] += 1
        content = json.dumps(body).encode() if body is not None else b""
        if self.rng.random() < self.faults:
            fault = self.rng.choice(("cut off", "unheard", "twice"))
            self.counts[fault] += 1
            if fault == "twice":
                with ThreadPoolExecutor(2) as both:
                    one, _ = both.map(lambda _: self._ask(method, path, credential, content), range(2))
                    return one
            self._drop(method, path, credential, content, whole=fault == "unheard")
        return self._ask(method, path, credential, content)

    def _connection(self) -> http.client.HTTPConnection:
        parts = urlsplit(self.url)
        kind = http.client.HTTPSConnection if parts.scheme == "https" else http.client.HTTPConnection
        return kind(parts.netloc, timeout=_TIMEOUT_S)

    def _ask(self, method: str, path: str, credential: str, content: bytes) -> Any:
        """Ask as a page does: a stack that has no time just now is asked again."""
        status, answer = 0, b""
        for _ in range(_MAX_BUSY_ATTEMPTS):
            start = time.perf_counter()
            status, answer = self._send(method, path, credential, content)
            self.latencies.append((time.perf_counter() - start) * 1e3)
            if status != HTTPStatus.SERVICE_UNAVAILABLE:
                break
            self.counts["asked again"] += 1
            time.sleep(1)
        if status >= HTTPStatus.MULTIPLE_CHOICES:
            raise LoadError(f"{method} {path}: {status} {answer[:300]!r}")
        return json.loads(answer)

    def _send(self, method: str, path: str, credential: str, content: bytes) -> tuple[int, bytes]:
        connection = self._connection()
        try:
            connection.request(method, path, content or None, {"Authorization": f"Bearer {credential}"})
            response = connection.getresponse()
            return response.status, response.read()
        finally:
            connection.close()

    def _drop(self, method: str, path: str, credential: str, content: bytes, *, whole: bool) -> None:
        connection = self._connection()
        connection.connect()
        head = (
            f"{method} {path} HTTP/1.1\r\nHost: {connection.host}\r\nAuthorization: Bearer {credential}\r\n"
        )
        sent = f"{head}Content-Length: {len(content)}\r\n\r\n".encode() + content
        line: socket.socket = connection.sock
        line.sendall(sent if whole else sent[: len(sent) // 2])
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
    """Run captures from many clients at once.

    Parameters
    ----------
    url, token
        Address of the stack, without a slash at the end, and its API token.
    sessions, clients
        Number of captures, and of clients that make them.
    cameras
        Number of cameras; all captures of one camera have the same optics.
    finished
        Share of the captures that continue to their end; the others end after one view.
    faults
        Share of the requests whose connection fails.
    seed
        Equal seeds send equal views.

    Raises
    ------
    LoadError
        If a response is an error, or a session has other views than were acknowledged.
    """
    lines = [Line(url, random.Random(f"{seed}/{n}"), faults) for n in range(clients)]  # noqa: S311

    ended: queue.SimpleQueue[None] = queue.SimpleQueue()

    def client(n: int) -> list[CaptureRecord]:
        heard = []
        try:
            for k in range(n, sessions, clients):
                camera, finish = f"Load camera {k % cameras:03d}", lines[n].rng.random() < finished
                heard.append(capture(lines[n], token, seed + k, camera, finish))
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
        sorted(latency for line in lines for latency in line.latencies),
        time.perf_counter() - start,
    )


def capture(line: Line, token: str, seed: int, camera: str, finish: bool) -> CaptureRecord:
    """Run one capture and return what was acknowledged; without `finish`, end after a view."""
    heard = CaptureRecord()
    session = line.call("POST", "/v1/auth", token)["session_id"]
    start = {
        "camera": camera,
        "platform": "X11; Linux x86_64",
        "img_size": _IMG_SIZE,
        "target_error": _TARGET_ERROR_PX,
    }
    state = line.call("POST", "/v1/session", session, start)
    for ids, points in observe_board(seed):
        if state["status"] == "converged" or (heard.views and not finish):
            break
        index = len(heard.views)
        view = {"index": index, "ids": ids, "points": points}
        state = line.call("POST", "/v1/session/views", session, view)
        if state["accepted"]:
            heard.views.append((index, ids, points))
    heard.calibration_id = state["calibration_id"]
    if finish and heard.calibration_id is None:
        raise LoadError(f"a capture of {camera} did not converge: {state['views']}")
    state = line.call("GET", "/v1/session", session)
    if [(v["index"], v["points"]) for v in state["views"]] != [(n, len(ids)) for n, ids, _ in heard.views]:
        raise LoadError(f"a capture of {camera} has other views than were acknowledged: {state['views']}")
    return heard


def observe_board(seed: int) -> Iterator[tuple[list[int], list[list[float]]]]:
    """Yield ids and points that a detector would find on one capture's frames."""
    rng = np.random.default_rng(seed)
    board = Board()
    matrix = np.array([[950.0, 0.0, 652.0], [0.0, 948.0, 351.0], [0.0, 0.0, 1.0]])
    camera = Camera("rectilinear", matrix, np.array([-0.12, 0.05, 0.0005, -0.0004, 0.0]), _IMG_SIZE)
    for n, (x, y) in enumerate(_TILTS):
        rotation = rotations.matrix(np.array([x, y, 0.1 * n]) + rng.normal(0, 0.04, 3))
        place = np.array([-4.5 + (n % 3 - 1), -3.0 + 0.5 * (n % 2), 9.0 + n % 4])
        q = camera.project(board.points @ rotation.T + place) + rng.normal(
            0, _NOISE_PX, (len(board.points), 2)
        )
        inside = np.flatnonzero(((q >= 0) & (q <= np.array(_IMG_SIZE) - 1)).all(axis=1))
        yield inside.tolist(), q[inside].tolist()


def main(arguments: Sequence[str] | None = None) -> int:
    """Drive the stack that is named; return the exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m infra.deploy.load_test", description="Many captures at once."
    )
    parser.add_argument("url", help="of the API, without /v1: http://127.0.0.1:8000")
    parser.add_argument("--token", default="cdb_dev_local")
    parser.add_argument("--sessions", type=int, default=200)
    parser.add_argument("--clients", type=int, default=64)
    parser.add_argument("--cameras", type=int, default=16)
    parser.add_argument("--faults", type=float, default=FAULT_RATE, help="share of requests that fail (0.2)")
    options = parser.parse_args(arguments)
    try:
        outcome = drive(
            options.url.rstrip("/"),
            options.token,
            options.sessions,
            options.clients,
            cameras=options.cameras,
            faults=options.faults,
        )
    except (LoadError, OSError) as error:
        print(f"calibDB: {error}", file=sys.stderr)
        return 1
    print("\n".join(outcome.lines()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
