"""The journal: what is at rest in one process, on disk before anyone is told it was written.

It keeps the resulting state of every address, not the history of operations, and leaves logging, snapshot and
truncation to SQLite: a commit is appended to the write-ahead log and synced (synchronous=FULL), a checkpoint
folds the log into the database and starts it over. So opening costs as much as there is state, however often
it was written.
"""

from __future__ import annotations

import os
import sqlite3
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.aws.emulator import salvage

# Kinds of address. Others may be kept too; only these two are in moto.
ITEM, OBJECT = "item", "object"

REINDEX = 'make ops ARGS="reindex"'
"""Command that rebuilds the index from the objects."""
_JOURNAL_VERSION = 2
_DAMAGED = (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)
_SCHEMA = """
CREATE TABLE IF NOT EXISTS state (
    kind TEXT NOT NULL,
    container TEXT NOT NULL,
    key TEXT NOT NULL,
    about TEXT NOT NULL,
    body BLOB NOT NULL,
    checksum INTEGER,
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

    Each record has a checksum. One that is damaged is left out; where the file itself is, what can be read of
    it goes into a new one, and the damaged file stays beside that.

    Parameters
    ----------
    path
        The database; made where there is none.
    known
        Whether there was one: then a missing or empty one is an error, and not a beginning.

    Raises
    ------
    JournalError
        If another process has it open, it is of a version this program does not know, or nothing of it can be
        read.
    """

    def __init__(self, path: Path | None, *, known: bool = False):
        self.damage: list[str] = []
        """Sentences about what was found damaged, each with the way on."""
        self._path = path
        if path is not None:
            _make(path, known=known)
        try:
            self._connection = _connect(path)
            try:
                self._open(known=known)
            except BaseException:
                self._connection.close()
                raise
        except sqlite3.DatabaseError as error:
            if error.sqlite_errorcode == sqlite3.SQLITE_BUSY:
                raise JournalError(f"{path} is in use by another process") from error
            if path is None or error.sqlite_errorcode & 0xFF not in _DAMAGED:
                raise JournalError(f"{path} cannot be opened: {error}") from error
            self._salvage(path, error)

    def _open(self, *, known: bool = False) -> None:
        execute = self._connection.execute
        # Exclusive from the first access on: it keeps a second process out, it ends with the process however
        # that ends, and it spares the log its shared-memory index.
        execute("PRAGMA locking_mode = EXCLUSIVE")
        execute("PRAGMA journal_mode = WAL")
        execute("PRAGMA synchronous = FULL")
        execute("PRAGMA journal_size_limit = 16777216")
        execute("BEGIN EXCLUSIVE")
        version = execute("PRAGMA user_version").fetchone()[0]
        if version not in (0, 1, _JOURNAL_VERSION):
            execute("ROLLBACK")
            raise JournalError(
                f"journal version {version} is not {_JOURNAL_VERSION}; it was written by another release"
            )
        if known and version == 0:
            execute("ROLLBACK")
            raise _empty(self._path)
        execute(_SCHEMA)
        if version == 1:
            execute("ALTER TABLE state ADD COLUMN checksum INTEGER")
        execute(f"PRAGMA user_version = {_JOURNAL_VERSION}")
        execute("COMMIT")
        if not salvage.is_sound(self._connection):
            raise _malformed_error()

    def _salvage(self, path: Path, error: sqlite3.DatabaseError) -> None:
        """Begin a new database with what can be read of the damaged one."""
        try:
            rows = salvage.readable_rows(path)
        except sqlite3.DatabaseError as unreadable:
            raise JournalError(
                f"{path} is damaged ({unreadable}) and nothing of it can be read: put back a copy of it, "
                f"or move the folder {path.parent} away to begin anew"
            ) from error
        kept = salvage.set_aside(path)
        _make(path, known=False)
        self._connection = _connect(path)
        self._open()
        sound = [change for row in rows if (change := _change(*row)) is not None]
        self.commit(sound)
        self.damage.append(
            f"{path} was damaged ({error}): {len(sound)} records could be read and others may be lost; "
            f"the damaged file is kept as {kept.name}. Put back a copy of the folder if you have one, or go "
            f"on, and rebuild the index by `{REINDEX}`"
        )

    def load(self, kind: str) -> Iterator[Change]:
        """Yield all there is of a kind, in the order it first came, without damaged records."""
        rows = self._connection.execute(
            "SELECT rowid, CAST(kind AS BLOB), CAST(container AS BLOB), CAST(key AS BLOB), "
            "CAST(about AS BLOB), body, checksum FROM state WHERE kind = ? ORDER BY rowid",
            (kind,),
        )
        lost = []
        for number, *row in rows:
            change = _change(*row)
            if change is None:
                lost.append(_record_name(number, *row[:3]))
            else:
                yield change
        self.leave_out(lost)

    def has_records(self) -> bool:
        """Tell whether anything was ever written."""
        return self._connection.execute("SELECT 1 FROM state LIMIT 1").fetchone() is not None

    def leave_out(self, records: Sequence[str]) -> None:
        """Note that these records are damaged and left out."""
        if records:
            more = f" and {len(records) - 3} more" if len(records) > 3 else ""
            self.damage.append(
                f"{self._path}: {len(records)} damaged records are left out ({', '.join(records[:3])}"
                f"{more}); put back a copy of the folder, or go on, and rebuild the index by `{REINDEX}`"
            )

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
                        "INSERT INTO state (kind, container, key, about, body, checksum) "
                        "VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT DO UPDATE SET "
                        "about = excluded.about, body = excluded.body, checksum = excluded.checksum",
                        (*address, change.content.about, change.content.body, _checksum(change)),
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


def _make(path: Path, *, known: bool) -> None:
    """Make the folder and the file, for their owner alone; JournalError where they cannot be, or are lost."""
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        if known and (not path.exists() or path.stat().st_size == 0):
            raise _empty(path)
        # SQLite gives its log the database's permissions.
        os.close(os.open(path, os.O_CREAT | os.O_RDWR, 0o600))
    except OSError as error:
        raise JournalError(f"{path.parent} cannot hold the data: {error.strerror}") from error


def _connect(path: Path | None) -> sqlite3.Connection:
    return sqlite3.connect(path or ":memory:", timeout=0.0, isolation_level=None, check_same_thread=False)


def _empty(path: Path | None) -> JournalError:
    return JournalError(
        f"{path} is missing or empty, and the files beside it belong to it: put back a copy of it, or move "
        "the whole folder away to begin anew"
    )


def _malformed_error() -> sqlite3.DatabaseError:
    error = sqlite3.DatabaseError("its pages do not fit together")
    error.sqlite_errorcode = sqlite3.SQLITE_CORRUPT
    return error


def _checksum(change: Change) -> int:
    """CRC-32 of a record and its address."""
    address, content = change.address, change.content or Content(b"")
    texts = (address.kind, address.container, address.key, content.about)
    return zlib.crc32(b"\0".join([*(text.encode() for text in texts), content.body]))


def _change(
    kind: bytes, container: bytes, key: bytes, about: bytes, body: bytes, checksum: int | None
) -> Change | None:
    """Return a stored record; None where it is damaged. Records of an earlier release have no checksum."""
    try:
        address = Address(kind.decode(), container.decode(), key.decode())
        change = Change(address, Content(bytes(body), about.decode()))
    except (UnicodeDecodeError, AttributeError, TypeError):  # of another type: overwritten
        return None
    return change if checksum is None or checksum == _checksum(change) else None


def _record_name(number: int, kind: object, container: object, key: object) -> str:
    """Name a damaged record: by kind, container and key as far as they can be read."""
    texts = [part.decode(errors="replace") for part in (kind, container, key) if isinstance(part, bytes)]
    return " ".join(texts)[:120] or f"row {number}"
