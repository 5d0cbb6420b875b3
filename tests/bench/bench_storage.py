"""The SQLite file of the server: what a write costs, and a start after many."""

import itertools
import json
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from calibdb.store.sqlite import SqliteObjects, SqliteTable
from infra.server.folder import Folder
from tests.bench.table import Row, p50

WRITES = 20_000
CAMERAS = 100
DOCUMENT = json.dumps({"views": [[round(0.37 * n, 3), round(0.11 * n, 3)] for n in range(600)]}).encode()
ATTRIBUTES = {f"a{n}": f"value {n}" for n in range(12)}


def rows() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        folder = Folder(place)
        table, objects = SqliteTable(folder.database), SqliteObjects(folder.database, "keypoints")

        def put(number: int) -> None:
            table.put({"pk": f"CAMERA#{number}", "sk": "CALIBRATION#1", **ATTRIBUTES})

        def pair(number: int) -> None:
            objects.put(f"calibrations/{number}.json", DOCUMENT)
            put(number)

        def query() -> None:
            assert len(list(table.query("CAMERA#7", "CALIBRATION#"))) == 1

        for number in range(CAMERAS):
            pair(number)
        yield Row(f"SQLite: query, {CAMERAS} cameras", p50(query), None, "ms")
        begun = time.perf_counter()
        with ThreadPoolExecutor(16) as pool:
            list(pool.map(pair, range(CAMERAS, WRITES // 2)))
        each = (time.perf_counter() - begun) / (WRITES - 2 * CAMERAS) * 1e3
        yield Row("SQLite: write, 16 threads, each", each, None, "ms", f"{1e3 / each:.0f}/s")
        numbers = itertools.count(WRITES)
        yield Row("SQLite: write, 1 thread, p50", p50(lambda: put(next(numbers))), None, "ms")
        yield Row(f"SQLite: query, {WRITES // 2} cameras", p50(query), None, "ms")
        folder.close()
        begun = time.perf_counter()
        folder = Folder(place)
        elapsed = time.perf_counter() - begun
        folder.close()
        yield Row(f"SQLite: opened and checked after {WRITES} writes", elapsed, 3, "s", "each to its own key")
