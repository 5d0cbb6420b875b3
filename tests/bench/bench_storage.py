"""The embedded storage: what a write costs, and a start after many."""

import itertools
import json
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from tests.bench.table import Row, p50
from tests.helpers.stack.toy_storage import BUCKET, TABLE, dynamodb, put, s3, storage

WRITES = 20_000
CAMERAS = 100
DOCUMENT = json.dumps({"views": [[round(0.37 * n, 3), round(0.11 * n, 3)] for n in range(600)]}).encode()


def query(client: Any) -> None:
    found = client.query(
        TableName=TABLE,
        KeyConditionExpression="pk = :camera AND begins_with(sk, :kind)",
        ExpressionAttributeValues={":camera": {"S": "CAMERA#7"}, ":kind": {"S": "CALIBRATION#"}},
    )
    assert found["Count"] == 1


def rows() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as name:
        place = Path(name)
        with storage(place):
            client, files = dynamodb(), s3()
            attributes = {f"a{n}": {"S": f"value {n}"} for n in range(12)}

            def pair(number: int) -> None:
                files.put_object(Bucket=BUCKET, Key=f"calibrations/{number}.json", Body=DOCUMENT)
                put(client, f"CAMERA#{number}", "CALIBRATION#1", **attributes)

            for number in range(CAMERAS):
                pair(number)
            yield Row(f"embedded store: query, {CAMERAS} cameras", p50(lambda: query(client)), None, "ms")
            start = time.perf_counter()
            with ThreadPoolExecutor(16) as pool:
                list(pool.map(pair, range(CAMERAS, WRITES // 2)))
            each = (time.perf_counter() - start) / (WRITES - 2 * CAMERAS) * 1e3
            yield Row("embedded store: write, 16 threads, each", each, None, "ms", f"{1e3 / each:.0f}/s")
            free = itertools.count(WRITES)
            one = p50(lambda: put(client, f"CAMERA#{next(free)}"))
            yield Row("embedded store: write, 1 thread, p50", one, None, "ms")
            yield Row(f"embedded store: query, {WRITES // 2} cameras", p50(lambda: query(client)), None, "ms")
        start = time.perf_counter()
        with storage(place) as store:
            elapsed = time.perf_counter() - start
            assert store.restored >= WRITES
        yield Row(f"embedded store: opened after {WRITES} writes", elapsed, 3, "s", "each to its own key")
