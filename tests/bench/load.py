"""Requests over keep-alive connections, from a process of its own."""

import http.client
import json
import socket
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Load:
    """What was measured, ms: `each`, the wall time over the number of requests, and `latencies`, sorted."""

    each: float
    latencies: list[float]

    def percentile(self, share: float) -> float:
        return self.latencies[min(len(self.latencies) - 1, int(share * len(self.latencies)))]


def drive(url: str, path: str, requests: int, clients: int) -> Load:
    """Send GET requests from another process; every answer must be a 200."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.load", url, path, str(requests), str(clients)],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    return Load(**json.loads(done.stdout))


def client(address: str, path: str, requests: int) -> list[float]:
    connection = http.client.HTTPConnection(address)
    connection.connect()
    connection.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    latencies = []
    for _ in range(requests):
        start = time.perf_counter()
        connection.request("GET", path)
        response = connection.getresponse()
        body = response.read()
        latencies.append((time.perf_counter() - start) * 1e3)
        if response.status != 200:
            raise SystemExit(f"{response.status}: {body[:200]!r}")
    connection.close()
    return latencies


def main(url: str, path: str, requests: str, clients: str) -> None:
    count = int(clients)
    with ThreadPoolExecutor(count) as pool:
        start = time.perf_counter()
        share = int(requests) // count
        each = [pool.submit(client, url.removeprefix("http://"), path, share) for _ in range(count)]
        latencies = sorted(latency for future in each for latency in future.result())
        elapsed = time.perf_counter() - start
    print(json.dumps({"each": elapsed * 1e3 / len(latencies), "latencies": latencies}))


if __name__ == "__main__":
    main(*sys.argv[1:])
