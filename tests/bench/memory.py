"""Memory of a server's processes under a mixed load: `make bench DOCS=memory`, `MINUTES=10`.

Two processes serve lookups, pages and captures. The resident memory of each is read every ten seconds.
"""

import os
import statistics
import subprocess
import threading
import time
from pathlib import Path

from infra.server.server import DEVELOPMENT_TOKEN
from tests.bench import load
from tests.bench.captures import drive

WORKERS, REQUESTS, SAMPLE_S = 2, 10_000, 10.0
# So many that few calibrations meet in a refit, whose memory grows with their number.
CAMERAS = 1000
KINDS = (
    load.KNOWN,
    load.lookup("Another camera", miss="ok"),
    *map(load.page, ("/", "/calibrate/", "/docs/api/")),
    load.HEALTH,
)


def memory_mb(pid: int | str) -> float:
    """Resident memory of a process, MB."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.partition("VmRSS:")[2].split()[0]) / 1024


def largest_mb(parent: int) -> float:
    """Largest resident memory of the children of a process, MB."""
    children = subprocess.run(["pgrep", "-P", str(parent)], capture_output=True, text=True, check=True)
    return max(map(memory_mb, children.stdout.split()))


def send_all_kinds(url: str, requests: int) -> None:
    """Send so many requests that leave nothing behind."""
    for kind in KINDS:
        load.drive(url, kind, requests=requests // len(KINDS), clients=4)


def mixed_load(url: str, end: float) -> None:
    """Send requests of all kinds, and captures, until a time of the monotonic clock."""
    while time.monotonic() < end:
        load.drive(url, load.KNOWN, requests=2000, clients=8)
        send_all_kinds(url, 1000)
        drive(url, DEVELOPMENT_TOKEN, 6, 4, cameras=CAMERAS, faults=0.0, seed=round(time.monotonic()))


def main() -> None:
    minutes = float(os.environ.get("MINUTES", "10"))
    with load.serving_known_camera(WORKERS=str(WORKERS)) as server:
        load.drive(server.url, load.KNOWN, requests=WORKERS * REQUESTS, clients=8)
        print(f"after {REQUESTS} lookups each: {largest_mb(server.process.pid):.0f} MB at most")
        mixed = threading.Thread(target=mixed_load, args=(server.url, time.monotonic() + 60 * minutes))
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
