"""One request, again and again over keep-alive sockets, from a process of its own."""

import json
import select
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from infra.server.server import Server
from tests.helpers.data import ROOT
from tests.helpers.service.client import CAMERA, TOKEN
from tests.helpers.service.published import calibration, publish
from tests.helpers.stack.processes import LocalProcess

Request = tuple[str, str, Mapping[str, str], str]
"""Method, path, headers and body."""
SPIN_S = 0.002
"""Before a request is due, for which the process does not sleep: the clock of `epoll` has milliseconds."""


def lookup(camera: str, **more: object) -> Request:
    headers = {"authorization": f"Bearer {TOKEN}", "content-type": "application/json"}
    return "POST", "/v1/lookup", headers, json.dumps({**CAMERA, "camera": camera, **more})


LABEL = "Measured camera (046d:0825)"
KNOWN = lookup(LABEL)
HEALTH: Request = ("GET", "/healthz", {}, "")


def page(path: str) -> Request:
    return "GET", path, {"accept-encoding": "gzip"}, ""


@dataclass(frozen=True)
class Load:
    """Measurements, ms: `each`, the wall time over the number of requests, and `latencies`."""

    each: float
    latencies: list[float]


def drive(url: str, request: Request, *, requests: int, clients: int, rate: float = 0.0) -> Load:
    """Send the request from another process; every response must be a 200.

    `rate`: requests per second of all clients together, whether the server keeps up or not. Latencies then
    count from the moment at which a request was due. 0: as fast as responses come.
    """
    method, path, headers, body = request
    address = url.removeprefix("http://")
    head = {"host": address, "content-length": str(len(body.encode())), **headers}
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in head.items())]
    asked = {"message": "\r\n".join([*lines, "", body]), "address": address}
    numbers = map(str, (requests, clients, rate))
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.load", json.dumps(asked), *numbers],
        cwd=ROOT,
        check=False,
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise RuntimeError(f"{method} {path}: {done.stderr}")
    return Load(**json.loads(done.stdout))


@contextmanager
def serving_known_camera(**environment: str) -> Iterator[LocalProcess]:
    """Run a server to which one camera, `LABEL`, is known."""
    with tempfile.TemporaryDirectory() as place:
        data_dir = Path(place, "data")
        with Server(data_dir) as stack:
            publish(stack, *(calibration(LABEL, n) for n in range(5)), models=())
        with LocalProcess(data_dir, environment) as server:
            yield server


def main(asked: Mapping[str, str], requests: int, clients: int, rate: float) -> None:
    host, _, port = asked["address"].partition(":")
    message = asked["message"].encode()
    poll = select.epoll()
    connections = {}
    for _ in range(clients):
        connection = socket.create_connection((host, int(port)))
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        poll.register(connection, select.EPOLLIN)
        connections[connection.fileno()] = connection
    sent, received, latencies = {}, dict.fromkeys(connections, b""), []
    idle, begun, length = list(connections), 0, 0
    start = time.perf_counter()
    while len(latencies) < requests:
        now = time.perf_counter()
        due = start + begun / rate if rate else now
        if idle and begun < requests and due <= now:
            number = idle.pop(0)  # in turn: the server closes one that rests for long
            sent[number] = due
            connections[number].sendall(message)
            begun += 1
            continue
        is_waiting = idle and begun < requests
        for number, _ in poll.poll(max(0.0, due - now - SPIN_S) if is_waiting else None):
            answer = received[number] + connections[number].recv(65536)
            if not answer.startswith(b"HTTP/1.1 200"):
                raise SystemExit(answer[:500].decode("latin-1") or "the connection was closed")
            if not length and b"\r\n\r\n" in answer:
                head, _, _ = answer.partition(b"\r\n\r\n")
                length = len(head) + 4 + int(head.lower().partition(b"content-length: ")[2].split()[0])
            if not length or len(answer) < length:
                received[number] = answer
                continue
            if len(answer) != length:
                raise SystemExit(answer[:500].decode("latin-1"))
            latencies.append((time.perf_counter() - sent[number]) * 1e3)
            received[number] = b""
            idle.append(number)
    elapsed = time.perf_counter() - start
    print(json.dumps({"each": elapsed * 1e3 / requests, "latencies": latencies}))


if __name__ == "__main__":
    main(json.loads(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), float(sys.argv[4]))
