"""Salvage of a damaged journal: its readable records go into a new one, the damaged file stays beside it."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path

Row = tuple[bytes, bytes, bytes, bytes, bytes, int | None]
"""kind, container, key, about, body and checksum of one record, as they are stored."""
MAX_PROBED_ROWS = 200_000
"""Rows that are read one by one where a scan breaks off."""
_RECORD_COLUMNS = "kind, container, key, about, body"


def is_sound(connection: sqlite3.Connection) -> bool:
    """Tell whether SQLite finds the structure of the database intact."""
    return bool(connection.execute("PRAGMA quick_check(1)").fetchone()[0] == "ok")


def readable_rows(path: Path) -> list[Row]:
    """Read every row that can still be read; raises sqlite3.DatabaseError where none can."""
    connection = sqlite3.connect(path, isolation_level=None)
    try:
        connection.text_factory = bytes
        # SQLite refuses a truncated file whole, but for this.
        connection.execute("PRAGMA writable_schema = ON")
        names = [str(row[1], "utf-8") for row in connection.execute("PRAGMA table_info(state)")]
        if not names:
            raise sqlite3.DatabaseError("it has no table of records")
        columns = f"{_RECORD_COLUMNS}, {'checksum' if 'checksum' in names else 'NULL'}"
        # From both ends until a damaged page, then each row of what lies between.
        first, broken = _scan(connection, columns, "ASC")
        if not broken:
            return list(first.values())
        last, _ = _scan(connection, columns, "DESC")
        low, high = max(first, default=0), min(last, default=MAX_PROBED_ROWS)
        between = _probe(connection, columns, range(low + 1, min(high, low + MAX_PROBED_ROWS)))
        found = {**first, **dict(between), **last}
        if not found:
            raise sqlite3.DatabaseError("none of its records can be read")
        return [found[number] for number in sorted(found)]
    finally:
        connection.close()


def _scan(connection: sqlite3.Connection, columns: str, direction: str) -> tuple[dict[int, Row], bool]:
    rows: dict[int, Row] = {}
    try:
        # Fixed words of this module alone.
        for number, *row in connection.execute(
            f"SELECT rowid, {columns} FROM state NOT INDEXED ORDER BY rowid {direction}"
        ):
            rows[number] = tuple(row)
    except sqlite3.DatabaseError:
        return rows, True
    return rows, False


def _probe(connection: sqlite3.Connection, columns: str, numbers: range) -> Iterator[tuple[int, Row]]:
    for number in numbers:
        try:
            row = connection.execute(
                f"SELECT {columns} FROM state NOT INDEXED WHERE rowid = ?",
                (number,),
            ).fetchone()
        except sqlite3.DatabaseError:
            continue
        if row is not None:
            yield number, row


def set_aside(path: Path) -> Path:
    """Rename a damaged journal and its log; return the new name, which no file had."""
    number = 1
    while (kept := path.with_name(f"{path.name}.damaged-{number}")).exists():
        number += 1
    path.rename(kept)
    for suffix in ("-wal", "-shm", "-journal"):
        log = path.with_name(path.name + suffix)
        if log.exists():
            log.rename(kept.with_name(kept.name + suffix))
    return kept
