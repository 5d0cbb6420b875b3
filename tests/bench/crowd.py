"""`make bench-load`: many clients at once on a line that drops; what was acknowledged must be there, once.

64 clients run 2,000 captures against a server of its own. One request in five is cut off half way, sent
without waiting for its answer, or sent twice at once; like a page that lost its network, the client then asks
again. `SESSIONS=500 CLIENTS=64 make bench-load` runs a part.
"""

import hashlib
import http.client
import json
import os
import random
import socket
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from calibdb.settings import Settings
from calibdb.store import Store
from infra.local import LocalStack
from tests.client import TOKEN, Truth
from tests.processes import LocalProcess

FAULTS = 0.2
CAMERAS = 16
_PATIENCE = 60.0  # s for one answer
_ENOUGH = 100.0  # px: the fourth accepted view ends the capture


@dataclass
class Heard:
    """What one client was told of one capture."""

    views: list[tuple[int, list[int], list[list[float]]]] = field(default_factory=list)
    calibration_id: str | None = None


@dataclass
class Line:
    """A connection of one client, which fails in some of its requests."""

    address: str
    rng: random.Random
    counts: Counter[str] = field(default_factory=Counter)
    latencies: list[float] = field(default_factory=list)

    def call(self, method: str, path: str, credential: str, body: object = None) -> Any:
        """Ask until there is an answer; it must be one of success."""
        self.counts["requests"] += 1
        if self.rng.random() < FAULTS:
            fault = self.rng.choice(("cut off", "unheard", "twice"))
            self.counts[fault] += 1
            if fault == "twice":
                with ThreadPoolExecutor(2) as both:
                    one, _ = both.map(lambda _: self._ask(method, path, credential, body), range(2))
                    return one
            self._drop(method, path, credential, body, whole=fault == "unheard")
        return self._ask(method, path, credential, body)

    def _ask(self, method: str, path: str, credential: str, body: object) -> Any:
        start = time.perf_counter()
        connection = http.client.HTTPConnection(self.address, timeout=_PATIENCE)
        connection.request(
            method, path, json.dumps(body) if body else None, {"Authorization": f"Bearer {credential}"}
        )
        response = connection.getresponse()
        content = response.read()
        connection.close()
        self.latencies.append((time.perf_counter() - start) * 1e3)
        if response.status >= 300:
            raise RuntimeError(f"{method} {path}: {response.status} {content[:300]!r}")
        return json.loads(content)

    def _drop(self, method: str, path: str, credential: str, body: object, *, whole: bool) -> None:
        content = json.dumps(body).encode() if body else b""
        head = f"{method} {path} HTTP/1.1\r\nHost: {self.address}\r\nAuthorization: Bearer {credential}\r\n"
        sent = f"{head}Content-Length: {len(content)}\r\n\r\n".encode() + content
        host, port = self.address.split(":")
        with socket.create_connection((host, int(port)), _PATIENCE) as line:
            line.sendall(sent if whole else sent[: len(sent) // 2])


def poses() -> Iterator[dict[str, list[float]]]:
    """Yield poses of a board of 9 x 6 squares that teach something, one after the other."""
    tilts = ((0.5, 0.0), (-0.5, 0.1), (0.1, 0.55), (0.0, -0.6), (0.4, 0.4), (-0.4, -0.4), (0.45, -0.4))
    for n, (x, y) in enumerate(tilts):
        yield {"rvec": [x, y, 0.1 * n], "tvec": [-4.5 + (n % 3 - 1), -3.0 + 0.5 * (n % 2), 9.0 + (n % 4)]}


def capture(line: Line, number: int, finish: bool) -> Heard:
    """Run one capture and return what was acknowledged; where not to `finish`, end after a view."""
    heard = Heard()
    truth = Truth(seed=number)
    session = line.call("POST", "/v1/auth", TOKEN)["session_id"]
    camera = {"camera": f"Test camera {number % CAMERAS:02d}", "platform": "X11; Linux x86_64"}
    start = {**camera, "img_size": [1280, 720], "target_error": _ENOUGH}
    state = line.call("POST", "/v1/session", session, start)
    for pose in poses():
        if state["status"] == "converged" or (heard.views and not finish):
            break
        ids, points = truth.see(pose)
        index = len(heard.views)
        view = {"index": index, "ids": ids, "points": points}
        state = line.call("POST", "/v1/session/views", session, view)
        if state["accepted"]:
            heard.views.append((index, ids, points))
    heard.calibration_id = state["calibration_id"]
    if finish and heard.calibration_id is None:
        raise RuntimeError(f"capture {number} did not converge: {state}")
    state = line.call("GET", "/v1/session", session)
    if [(v["index"], v["points"]) for v in state["views"]] != [(n, len(ids)) for n, ids, _ in heard.views]:
        raise RuntimeError(f"capture {number} holds other views than were acknowledged: {state['views']}")
    return heard


@dataclass(frozen=True)
class Outcome:
    """What happened, and how it went."""

    heard: list[Heard]
    counts: Counter[str]
    latencies: list[float]  # ms, sorted
    seconds: float

    def percentile(self, share: float) -> float:
        return self.latencies[min(len(self.latencies) - 1, int(share * len(self.latencies)))]


def drive(url: str, sessions: int, clients: int, finished: float = 1.0, seed: int = 0) -> Outcome:
    """Run `sessions` captures, a share `finished` of them to their end, from `clients` clients at once."""
    lines = [Line(url.removeprefix("http://"), random.Random(f"{seed}/{n}")) for n in range(clients)]

    def client(n: int) -> list[Heard]:
        mine = range(n, sessions, clients)
        return [capture(lines[n], seed + k, lines[n].rng.random() < finished) for k in mine]

    start = time.perf_counter()
    with ThreadPoolExecutor(clients) as pool:
        heard = [capture for each in pool.map(client, range(clients)) for capture in each]
    counts: Counter[str] = sum((line.counts for line in lines), Counter())
    latencies = sorted(latency for line in lines for latency in line.latencies)
    return Outcome(heard, counts, latencies, time.perf_counter() - start)


def missing_or_double(data_dir: Path, heard: list[Heard]) -> list[str]:
    """Return what is wrong with what a server, by now stopped, has kept; nothing, where all is there once."""
    with LocalStack(data_dir) as stack:
        store = Store.of(Settings.from_environment(stack.environment))
        kept = Counter(document.id for document in store.calibrations.all())
        indexed = Counter(
            member.id
            for key in {document.camera_key for document in store.calibrations.all()}
            for mode in store.calibrations.modes(key)
            for member in store.calibrations.newest(mode, 10**6)
        )
        expected = Counter(one.calibration_id for one in heard if one.calibration_id)
        wrong = [f"{name}: acknowledged {expected[name]} times" for name in expected if expected[name] != 1]
        wrong += [f"{name}: kept {kept[name]} times" for name in {*expected, *kept} if kept[name] != 1]
        wrong += [f"{name}: not acknowledged" for name in kept if name not in expected]
        wrong += [f"{name}: indexed {indexed[name]} times" for name in expected if indexed[name] != 1]
        for one in heard:
            document = store.calibrations.get(one.calibration_id) if one.calibration_id else None
            if document is not None:
                views = [
                    (view.index, list(view.ids), [list(p) for p in view.points]) for view in document.views
                ]
                if digest(views) != digest(one.views):
                    wrong.append(f"{document.id}: other views than were acknowledged")
    return wrong


def digest(views: object) -> str:
    return hashlib.sha256(json.dumps(views).encode()).hexdigest()


def main() -> int:
    """Run it all and print what came out."""
    sessions, clients = int(os.environ.get("SESSIONS", "2000")), int(os.environ.get("CLIENTS", "64"))
    with tempfile.TemporaryDirectory() as folder:
        data_dir = Path(folder) / "data"
        with LocalProcess(data_dir) as server:
            outcome = drive(server.url, sessions, clients)
            if server.stop() != 0:
                print("the server did not end well", file=sys.stderr)
                return 1
        wrong = missing_or_double(data_dir, outcome.heard)
    views = sum(len(one.views) for one in outcome.heard)
    faults = {name: n for name, n in sorted(outcome.counts.items()) if name != "requests"}
    print(f"{sessions} captures by {clients} clients in {outcome.seconds:.0f} s")
    print(f"{outcome.counts['requests']} requests, faults: {faults}")
    print(
        f"answers after {outcome.percentile(0.5):.0f} ms (median), {outcome.percentile(0.95):.0f} ms (95 %)"
    )
    print(f"{views} views and {sessions} calibrations acknowledged; {len(wrong)} missing, double or changed")
    print("\n".join(wrong[:20]))
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
