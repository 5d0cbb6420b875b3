"""`make bench DOCS=load`: every view that a server acknowledges over failing connections is stored, once.

`SESSIONS=2000` captures from `CLIENTS=64` clients, by `tests.bench.captures`.
"""

import os
import sys
import tempfile
from collections import Counter
from pathlib import Path

from calibdb.settings import Settings
from calibdb.store import Store
from infra.deploy.smoke_capture import CaptureRecord
from infra.server.server import DEVELOPMENT_TOKEN, Server
from tests.bench.captures import drive
from tests.helpers.stack.processes import LocalProcess


def missing_or_double(data_dir: Path, heard: list[CaptureRecord]) -> list[str]:
    """List the captures that a stopped server lost or stored twice."""
    with Server(data_dir) as stack:
        store = Store.of(Settings.from_environment(stack.environment))
        stored = list(store.calibrations.all())
        documents = {document.id: document for document in stored}
        kept = Counter(document.id for document in stored)
        indexed = Counter(
            counted.id
            for key in {document.camera_key for document in documents.values()}
            for mode in store.calibrations.modes(key)
            for counted in store.calibrations.newest(mode, 10**6)
        )
    acknowledged = {one.calibration_id: one for one in heard if one.calibration_id}
    told = Counter(one.calibration_id for one in heard if one.calibration_id)
    wrong = [f"{name}: acknowledged {n} times" for name, n in told.items() if n != 1]
    wrong += [f"{name}: not acknowledged" for name in kept if name not in acknowledged]
    for name, one in acknowledged.items():
        if (kept[name], indexed[name]) != (1, 1):
            wrong.append(f"{name}: kept {kept[name]} times, indexed {indexed[name]} times")
            continue
        views = [(v.index, list(v.ids), [list(p) for p in v.points]) for v in documents[name].views]
        if views != one.views:
            wrong.append(f"{name}: other views than were acknowledged")
    return wrong


def main() -> int:
    sessions, clients = int(os.environ.get("SESSIONS", "2000")), int(os.environ.get("CLIENTS", "64"))
    with tempfile.TemporaryDirectory() as folder:
        data_dir = Path(folder) / "data"
        with LocalProcess(data_dir) as server:
            outcome = drive(server.url, DEVELOPMENT_TOKEN, sessions, clients)
            if server.stop(timeout_s=600) != 0:
                print("the server did not end well", file=sys.stderr)
                return 1
        wrong = missing_or_double(data_dir, outcome.heard)
    print("\n".join(outcome.lines()))
    views = sum(len(one.views) for one in outcome.heard)
    print(f"{views} views and {sessions} calibrations acknowledged; {len(wrong)} missing, double or changed")
    print("\n".join(wrong[:20]))
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
