"""The journal: what is at rest in one process, on disk before anyone is told it was written.

It keeps the resulting state of every address, not the history of operations, and leaves logging, snapshot and
truncation to SQLite: a commit is appended to the write-ahead log and synced (synchronous=FULL), a checkpoint
folds the log into the database and starts it over. So opening costs as much as there is state, however often
it was written.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

# Kinds of address. Others may be kept too; only these two are in moto.
ITEM, OBJECT = "item", "object"

_JOURNAL_VERSION = 1
_SCHEMA = """
CREATE TABLE IF NOT EXISTS state (
    kind TEXT NOT NULL,
    container TEXT NOT NULL,
    key TEXT NOT NULL,
    about TEXT NOT NULL,
    body BLOB NOT NULL,
    UNIQUE (kind, container, key)
)
"""


class JournalError(Exception):
    """The journal could not be opened or written."""


@dataclass(frozen=True)
class Address:
    """Address of a record: an item of a table, an object of a bucket, an invoke in a queue."""

    kind: str
    container: str
    key: str


@dataclass(frozen=True)
class Content:
    """Record at an address: the bytes, and their metadata (JSON)."""

    body: bytes
    about: str = ""


@dataclass(frozen=True)
class Change:
    """Change of an address to a new record; None: removal."""

    address: Address
    content: Content | None


class Journal:
    """State on disk, or in memory when `path` is None. One thread at a time; the caller sees to that.

    Raises
    ------
    JournalError
        If another process has it open, or it is of a version this program does not know.
    """

    def __init__(self, path: Path | None):
        if path is not None:
            try:
                path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
                # SQLite gives its log the database's permissions.
                os.close(os.open(path, os.O_CREAT | os.O_RDWR, 0o600))
            except OSError as error:
                raise JournalError(f"{path.parent} cannot hold the data: {error.strerror}") from error
        self._connection = sqlite3.connect(
            path or ":memory:", timeout=0.0, isolation_level=None, check_same_thread=False
        )
        try:
            self._open()
        except sqlite3.OperationalError as error:
            self._connection.close()
            if error.sqlite_errorcode == sqlite3.SQLITE_BUSY:
                raise JournalError(f"{path} is in use by another process") from error
            raise JournalError(f"{path} cannot be opened: {error}") from error
        except BaseException:
            self._connection.close()
            raise

    def _open(self) -> None:
        execute = self._connection.execute
        # Exclusive from the first access on: it keeps a second process out, it ends with the process however
        # that ends, and it spares the log its shared-memory index.
        execute("PRAGMA locking_mode = EXCLUSIVE")
        execute("PRAGMA journal_mode = WAL")
        execute("PRAGMA synchronous = FULL")
        execute("PRAGMA journal_size_limit = 16777216")
        execute("BEGIN EXCLUSIVE")
        version = execute("PRAGMA user_version").fetchone()[0]
        if version not in (0, _JOURNAL_VERSION):
            execute("ROLLBACK")
            raise JournalError(
                f"journal version {version} is not {_JOURNAL_VERSION}; it was written by another release"
            )
        execute(_SCHEMA)
        execute(f"PRAGMA user_version = {_JOURNAL_VERSION}")
        execute("COMMIT")

    def load(self, kind: str) -> Iterator[Change]:
        """Yield all there is of a kind, in the order it first came."""
        rows = self._connection.execute(
            "SELECT kind, container, key, about, body FROM state WHERE kind = ? ORDER BY rowid", (kind,)
        )
        for kind, container, key, about, body in rows:
            yield Change(Address(kind, container, key), Content(body, about))

    def fetch(self, address: Address) -> Content | None:
        """Read the record at an address.

        Raises
        ------
        JournalError
            If it cannot be read.
        """
        try:
            row = self._connection.execute(
                "SELECT body, about FROM state WHERE kind = ? AND container = ? AND key = ?",
                (address.kind, address.container, address.key),
            ).fetchone()
        except sqlite3.Error as error:
            raise JournalError(f"the journal could not be read: {error}") from error
        return Content(*row) if row else None

    def commit(self, changes: Iterable[Change]) -> None:
        """Make the changes durable, in their order, all or none.

        Raises
        ------
        JournalError
            If they are not durable (a full disk, say); then none is.
        """
        execute = self._connection.execute
        try:
            execute("BEGIN")
            for change in changes:
                address = (change.address.kind, change.address.container, change.address.key)
                if change.content is None:
                    execute("DELETE FROM state WHERE kind = ? AND container = ? AND key = ?", address)
                else:
                    execute(
                        "INSERT INTO state (kind, container, key, about, body) VALUES (?, ?, ?, ?, ?) "
                        "ON CONFLICT DO UPDATE SET about = excluded.about, body = excluded.body",
                        (*address, change.content.about, change.content.body),
                    )
            execute("COMMIT")
        except sqlite3.Error as error:
            if self._connection.in_transaction:
                execute("ROLLBACK")
            raise JournalError(f"the journal could not be written: {error}") from error

    def limit(self, pages: int) -> None:
        """Let the database grow to so many pages at most; for rehearsing a full disk."""
        self._connection.execute(f"PRAGMA max_page_count = {pages:d}")

    def close(self) -> None:
        """Fold the log into the database and let go of it."""
        self._connection.close()
