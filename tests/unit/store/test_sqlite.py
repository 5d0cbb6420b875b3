"""Connections to the SQLite file."""

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from calibdb.store.sqlite import FILE_NAME, Database, SqliteTable

READERS = 4


def open_files(path: Path) -> int:
    """Count the file descriptors of this process that are open on a file."""
    targets = (os.path.realpath(entry) for entry in Path("/proc/self/fd").iterdir())
    return sum(target == str(path) for target in targets)


def test_threads_of_requests_share_connections(tmp_path: Path) -> None:
    database = Database(tmp_path)
    table = SqliteTable(database)
    table.put({"pk": "P", "sk": "S"})
    for _ in range(50):
        with ThreadPoolExecutor(READERS) as threads:
            list(threads.map(lambda _: table.get("P", "S"), range(READERS)))
    assert 1 <= open_files(tmp_path / FILE_NAME) <= READERS
    database.close()
    assert open_files(tmp_path / FILE_NAME) == 0
