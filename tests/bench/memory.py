"""Memory of a server's processes under a mixed load: `make bench DOCS=memory` with MINUTES=10.

Two processes serve lookups, pages, dumps and captures. The resident memory of each is read every ten seconds.
"""

import json
import os
import statistics
import subprocess
import threading
import time
from pathlib import Path

from infra.server.server import DEVELOPMENT_TOKEN
from tests.bench import load
from tests.bench.captures import drive
from tests.helpers.service.client import CAMERA, TOKEN

WORKERS, REQUESTS, SAMPLE_S = 2, 10_000, 10.0
# So many that few calibrations meet in a refit, whose memory grows with their number.
CAMERAS = 1000


def memory_mb(pid: int | str) -> float:
    """Resident memory of a process, MB."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.partition("VmRSS:")[2].split()[0]) / 1024


def largest_mb(parent: int) -> float:
    """Largest resident memory of the children of a process, MB."""
    children = subprocess.run(["pgrep", "-P", str(parent)], capture_output=True, text=True, check=True)
    return max(map(memory_mb, children.stdout.split()))


def lookups(url: str, requests: int) -> None:
    """Send lookups of a known camera."""
    body = json.dumps({**CAMERA, "camera": load.LABEL})
    headers = {"authorization": f"Bearer {TOKEN}", "content-type": "application/json"}
    load.drive(url, "POST", "/v1/lookup", headers, body, requests=requests, clients=8)


def mixed_load(url: str, end: float) -> None:
    """Send lookups, pages and captures until a time of the monotonic clock."""
    while time.monotonic() < end:
        lookups(url, 2000)
        for path in ("/", "/calibrate/", "/docs/api/", "/healthz"):
            load.drive(url, "GET", path, {"accept-encoding": "gzip"}, "", requests=200, clients=4)
        drive(url, DEVELOPMENT_TOKEN, 6, 4, cameras=CAMERAS, faults=0.0, seed=round(time.monotonic()))


def main() -> None:
    """Print the memory after the lookups, and its course under the mixed load."""
    minutes = float(os.environ.get("MINUTES", "10"))
    with load.serving_known_camera(WORKERS=str(WORKERS)) as server:
        lookups(server.url, WORKERS * REQUESTS)
        print(f"after {REQUESTS} lookups each: {largest_mb(server.process.pid):.0f} MB at most")
        end = time.monotonic() + 60 * minutes
        mixed = threading.Thread(target=mixed_load, args=(server.url, end))
        mixed.start()
        samples = []
        while mixed.is_alive():
            time.sleep(SAMPLE_S)
            samples.append(largest_mb(server.process.pid))
    parts = [samples[len(samples) * n // 5 : len(samples) * (n + 1) // 5] for n in range(5)]
    course = ", ".join(f"{statistics.median(part):.0f}" for part in parts if part)
    print(
        f"{minutes:g} minutes of mixed load: {course} MB (median of each fifth), {max(samples):.0f} at most"
    )


if __name__ == "__main__":
    main()
