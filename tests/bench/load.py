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
    """Measurements, ms: `each`, the wall time over the number of requests, and `latencies`, sorted."""

    each: float
    latencies: list[float]

    def percentile(self, share: float) -> float:
        return self.latencies[min(len(self.latencies) - 1, int(share * len(self.latencies)))]


def drive(url: str, path: str, requests: int, clients: int, rate: float = 0) -> Load:
    """Send GET requests from another process; every answer must be a 200.

    `rate`: requests a second, of all clients together, whether the server keeps up or not; latency then
    counts from the moment at which a request was due. 0: as fast as answers come.
    """
    done = subprocess.run(
        [sys.executable, "-m", "tests.bench.load", url, path, *map(str, (requests, clients, rate))],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    return Load(**json.loads(done.stdout))


def client(address: str, path: str, due: list[float]) -> list[float]:
    connection = http.client.HTTPConnection(address)
    connection.connect()
    connection.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    latencies = []
    for moment in due:
        if moment:
            time.sleep(max(0, moment - time.perf_counter()))
        start = moment or time.perf_counter()
        connection.request("GET", path)
        response = connection.getresponse()
        body = response.read()
        latencies.append((time.perf_counter() - start) * 1e3)
        if response.status != 200:
            raise SystemExit(f"{response.status}: {body[:200]!r}")
    connection.close()
    return latencies


def main(url: str, path: str, requests: int, clients: int, rate: float) -> None:
    with ThreadPoolExecutor(clients) as pool:
        start = time.perf_counter()
        due = [start + number / rate if rate else 0.0 for number in range(requests)]
        address = url.removeprefix("http://")
        each = [pool.submit(client, address, path, due[n::clients]) for n in range(clients)]
        latencies = sorted(latency for future in each for latency in future.result())
        elapsed = time.perf_counter() - start
    print(json.dumps({"each": elapsed * 1e3 / len(latencies), "latencies": latencies}))


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), float(sys.argv[5]))
