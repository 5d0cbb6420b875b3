"""One request, again and again over keep-alive sockets, from a process of its own."""

import json
import socket
import subprocess
import sys
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

from tests.bench.load import ROOT, Load


def drive(
    url: str, method: str, path: str, headers: Mapping[str, str], body: str, *, requests: int, clients: int
) -> Load:
    """Send the request as fast as answers come; every answer must be a 200."""
    address = url.removeprefix("http://")
    head = {"host": address, "content-length": str(len(body.encode())), **headers}
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in head.items())]
    asked = {"message": "\r\n".join([*lines, "", body]), "address": address}
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.raw_load", json.dumps(asked), str(requests), str(clients)],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    return Load(**json.loads(done.stdout))


def client(address: str, message: bytes, requests: int) -> list[float]:
    host, _, port = address.partition(":")
    latencies = []
    with socket.create_connection((host, int(port))) as connection:
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        length = 0
        for _ in range(requests):
            start = time.perf_counter()
            connection.sendall(message)
            answer = connection.recv(65536)
            if not length:
                head, _, _ = answer.partition(b"\r\n\r\n")
                length = len(head) + 4 + int(head.lower().partition(b"content-length: ")[2].split()[0])
            while len(answer) < length:
                answer += connection.recv(65536)
            latencies.append((time.perf_counter() - start) * 1e3)
            if not answer.startswith(b"HTTP/1.1 200") or len(answer) != length:
                raise SystemExit(answer[:500].decode("latin-1"))
    return latencies


def main(asked: Mapping[str, str], requests: int, clients: int) -> None:
    with ThreadPoolExecutor(clients) as pool:
        start = time.perf_counter()
        message = asked["message"].encode()
        each = [pool.submit(client, asked["address"], message, requests // clients) for _ in range(clients)]
        latencies = sorted(latency for future in each for latency in future.result())
        elapsed = time.perf_counter() - start
    print(json.dumps({"each": elapsed * 1e3 / len(latencies), "latencies": latencies}))


if __name__ == "__main__":
    main(json.loads(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
