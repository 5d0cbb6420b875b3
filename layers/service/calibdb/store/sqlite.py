"""The ports in one SQLite file, `calibdb.sqlite`; objects above 1 MB are files next to it.

A write returns after its transaction is on disk. Several processes may use the file at the same time. Each
row has a checksum, since SQLite would not notice a damaged page.
"""

import hashlib
import json
import os
import sqlite3
import threading
import time
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from calibdb.errors import UnavailableError
from calibdb.store.ports import Condition, Item, JobName, Jobs, Objects, Table

FILE_NAME = "calibdb.sqlite"
FOLDER_NAME = "objects"
SCHEMA_VERSION = 1
MAX_INLINE_BYTES = 1_000_000  # of an object's content that is in the database itself
_BUSY_TIMEOUT_S = 10.0
_MAX_PAUSE_S = 60.0  # before a job runs again
_RANGE = (
    "SELECT item FROM items WHERE pk = ? AND sk >= ? AND sk < ? AND sk > ? AND (ttl IS NULL OR ttl > ?) "
    "ORDER BY sk"
)
_PAGE_SIZE = 500  # rows that a listing reads at a time
_SCHEMA = """
CREATE TABLE items (pk TEXT, sk TEXT, item TEXT NOT NULL, ttl INTEGER, checksum INTEGER NOT NULL,
    PRIMARY KEY (pk, sk)) WITHOUT ROWID;
CREATE INDEX items_ttl ON items (ttl) WHERE ttl IS NOT NULL;
CREATE TABLE objects (bucket TEXT, name TEXT, tag TEXT NOT NULL, written INTEGER NOT NULL,
    media_type TEXT NOT NULL, cache_control TEXT, content BLOB);
CREATE UNIQUE INDEX objects_name ON objects (bucket, name);
CREATE TABLE jobs (id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL, payload BLOB NOT NULL,
    due REAL NOT NULL, attempts INTEGER NOT NULL DEFAULT 0, leased REAL NOT NULL DEFAULT 0, error TEXT);
"""


class SchemaError(Exception):
    """The file was written by a newer version, or is not a database of calibDB."""


@contextmanager
def available() -> Iterator[None]:
    """Turn a failure of SQLite or of the file system into UnavailableError."""
    try:
        yield
    except (sqlite3.Error, OSError) as error:
        raise UnavailableError(f"Storage did not answer ({error}).") from error


class Database:
    """The SQLite file in `folder`; None: in memory. `clock`: unix seconds.

    Raises SchemaError, or sqlite3.Error or OSError if the file cannot be opened. Methods: UnavailableError.
    """

    def __init__(self, folder: Path | None, clock: Callable[[], float] = time.time) -> None:
        self.folder = folder
        self.clock = clock
        self._path = ":memory:" if folder is None else folder / FILE_NAME
        self._local = threading.local()
        self._opened: list[sqlite3.Connection] = []
        self._writing = threading.RLock()
        connection = self._connect()
        self._idle = [connection]
        self._memory = connection if folder is None else None
        if folder is not None:
            (folder / FOLDER_NAME).mkdir(exist_ok=True)
        connection.execute("BEGIN IMMEDIATE")
        with connection:
            version = connection.execute("PRAGMA user_version").fetchone()[0]
            if version > SCHEMA_VERSION:
                raise SchemaError(
                    f"{self._path} was written by a newer version of calibDB (schema {version}, this version "
                    f"reads up to {SCHEMA_VERSION}): install that version"
                )
            if version == 0:
                for statement in filter(str.strip, _SCHEMA.split(";")):
                    connection.execute(statement)
                connection.execute(f"PRAGMA user_version={SCHEMA_VERSION}")

    @contextmanager
    def reading(self) -> Iterator[sqlite3.Connection]:
        """Yield a connection for reads: the one that this thread already uses, or an idle one."""
        connection: sqlite3.Connection | None = getattr(self._local, "connection", None)
        with available():
            if self._memory is not None:
                with self._writing:
                    yield self._memory
                return
            if connection is not None:
                yield connection
                return
            try:
                connection = self._idle.pop()
            except IndexError:
                connection = self._connect()
            self._local.connection = connection
            try:
                yield connection
            finally:
                self._local.connection = None
                self._idle.append(connection)

    @contextmanager
    def writing(self) -> Iterator[sqlite3.Connection]:
        """Yield a connection in a transaction, committed at the end of the block."""
        with self._writing, self.reading() as connection:
            connection.execute("BEGIN IMMEDIATE")
            with connection:
                yield connection

    def rows(self, query: str, *values: object) -> list[Any]:
        """Rows of a query."""
        with self.reading() as connection:
            return connection.execute(query, values).fetchall()

    def change(self, statement: str, *values: object) -> list[Any]:
        """Run a statement in a transaction of its own; return the rows that it returns."""
        with self.writing() as connection:
            return connection.execute(statement, values).fetchall()

    def checkpoint(self) -> None:
        """Copy the log into the file, as far as readers allow."""
        self.rows("PRAGMA wal_checkpoint(PASSIVE)")

    def sweep(self, lifetimes: Mapping[tuple[str, str], float]) -> int:
        """Delete what has expired; return the number of rows.

        `lifetimes`: seconds for which objects are kept, by bucket and prefix of the name.
        """
        now = self.clock()
        with self.writing() as connection:
            removed = connection.execute("DELETE FROM items WHERE ttl <= ?", (now,)).rowcount
        for (bucket, prefix), lifetime in lifetimes.items():
            expired = self.rows(
                "SELECT name FROM objects WHERE bucket = ? AND name >= ? AND name < ? AND written < ?",
                *(bucket, prefix, _after(prefix), now - lifetime),
            )
            removed += SqliteObjects(self, bucket).purge_all_versions(name for (name,) in expired)
        return removed

    def close(self) -> None:
        """Close all connections; the last process to do so copies the log into the file."""
        opened, self._opened, self._idle = self._opened, [], []
        for connection in opened:
            connection.close()

    def _connect(self) -> sqlite3.Connection:
        connection = sqlite3.connect(
            self._path, timeout=_BUSY_TIMEOUT_S, isolation_level=None, check_same_thread=False
        )
        self._opened.append(connection)
        connection.execute("PRAGMA journal_mode=WAL")
        connection.execute("PRAGMA synchronous=FULL")
        connection.execute("PRAGMA cache_size=-256")  # kB; the system caches the file for all connections
        return connection


class SqliteTable(Table):
    """`Table` in SQLite. Expired items do not exist."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def get(self, pk: str, sk: str, *, consistent: bool = True) -> Item | None:  # noqa: ARG002
        rows = self._database.rows(
            "SELECT item FROM items WHERE pk = ? AND sk = ? AND (ttl IS NULL OR ttl > ?)",
            *(pk, sk, self._database.clock()),
        )
        return json.loads(rows[0][0]) if rows else None

    def put(self, item: Item, condition: Condition | None = None) -> bool:
        return self.put_transaction([item], condition)

    def put_transaction(self, items: Sequence[Item], condition: Condition | None) -> bool:
        with self._database.writing() as connection:
            if not self._allows(items[0]["pk"], items[0]["sk"], condition):
                return False
            for item in items:
                _write_item(connection, item)
            return True

    def add(
        self, pk: str, sk: str, name: str, amount: int, *, limit: int | None = None, ttl: int | None = None
    ) -> int | None:
        with self._database.writing() as connection:
            item = self.get(pk, sk) or {"pk": pk, "sk": sk}
            total: int = item.get(name, 0) + amount
            if limit is not None and total > limit:
                return None
            item[name] = total
            if ttl is not None:
                item["ttl"] = ttl
            _write_item(connection, item)
            return total

    def remove(self, pk: str, sk: str, name: str) -> None:
        with self._database.writing() as connection:
            item = self.get(pk, sk)
            if item is not None and item.pop(name, None) is not None:
                _write_item(connection, item)

    def delete(self, pk: str, sk: str, condition: Condition | None = None) -> bool:
        with self._database.writing() as connection:
            if not self._allows(pk, sk, condition):
                return False
            connection.execute("DELETE FROM items WHERE pk = ? AND sk = ?", (pk, sk))
            return True

    def query(
        self,
        pk: str,
        prefix: str,
        *,
        newest_first: bool = False,
        limit: int | None = None,
        consistent: bool = False,  # noqa: ARG002
        after: str | None = None,
    ) -> list[Item]:
        bounds = pk, prefix, _after(prefix), after or "", self._database.clock()
        order = " DESC LIMIT ?" if newest_first else " LIMIT ?"
        rows = self._database.rows(_RANGE + order, *bounds, -1 if limit is None else limit)
        return [json.loads(text) for (text,) in rows]

    def keys(self, pk_prefix: str) -> Iterator[tuple[str, str]]:
        pk, sk = pk_prefix, ""
        while True:
            rows = self._database.rows(
                "SELECT pk, sk FROM items WHERE (pk, sk) > (?, ?) AND pk < ? "
                "AND (ttl IS NULL OR ttl > ?) ORDER BY pk, sk LIMIT ?",
                *(pk, sk, _after(pk_prefix), self._database.clock(), _PAGE_SIZE),
            )
            yield from rows
            if len(rows) < _PAGE_SIZE:
                return
            pk, sk = rows[-1]

    def _allows(self, pk: str, sk: str, condition: Condition | None) -> bool:
        return condition is None or condition.holds(self.get(pk, sk))


def _write_item(connection: sqlite3.Connection, item: Item) -> None:
    text = json.dumps(item, ensure_ascii=False, separators=(",", ":"))
    pk, sk, ttl = item["pk"], item["sk"], item.get("ttl")
    checksum = item_checksum(pk, sk, text, ttl)
    connection.execute("INSERT OR REPLACE INTO items VALUES (?, ?, ?, ?, ?)", (pk, sk, text, ttl, checksum))


class SqliteObjects(Objects):
    """`Objects` of one bucket in SQLite. The tag is the SHA-256 of the content."""

    def __init__(self, database: Database, bucket: str) -> None:
        self._database = database
        self._bucket = bucket

    def get_version(self, name: str) -> tuple[bytes, str] | None:
        while True:
            row = self._row("content, tag", name)
            if row is None:
                return None
            content, tag = row
            if content is not None:
                return content, tag
            with available():
                try:
                    return self._file(tag).read_bytes(), tag
                except FileNotFoundError:  # replaced or deleted between the two reads
                    if self._tag(name) == tag:
                        raise

    def replace(self, name: str, content: bytes, tag: str) -> bool:
        return self._write(name, content, lambda stored: stored == tag)

    def create(self, name: str, content: bytes) -> bool:
        return self._write(name, content, lambda stored: stored is None)

    def put(
        self,
        name: str,
        content: bytes,
        media_type: str = "application/json",
        cache_control: str | None = None,
    ) -> None:
        self._write(name, content, lambda _: True, media_type, cache_control)

    def delete(self, names: Sequence[str]) -> None:
        self.purge_all_versions(names)

    def names(self, prefix: str, after: str = "") -> Iterator[str]:
        while True:
            rows = self._database.rows(
                "SELECT name FROM objects WHERE bucket = ? AND name >= ? AND name < ? AND name > ? "
                "ORDER BY name LIMIT ?",
                *(self._bucket, prefix, _after(prefix), after, _PAGE_SIZE),
            )
            for (after,) in rows:
                yield after
            if len(rows) < _PAGE_SIZE:
                return

    def headers(self, name: str) -> tuple[str, str | None]:
        """Return media type and `Cache-Control` of an object that exists."""
        media_type, cache_control = self._row("media_type, cache_control", name)
        return media_type, cache_control

    def _write(
        self,
        name: str,
        content: bytes,
        allowed: Callable[[str | None], bool],
        media_type: str = "application/json",
        cache_control: str | None = None,
    ) -> bool:
        tag = hashlib.sha256(content).hexdigest()
        inline = self._database.folder is None or len(content) <= MAX_INLINE_BYTES
        written = int(self._database.clock())
        with self._database.writing() as connection:
            before = self._tag(name)
            if not allowed(before):
                return False
            if not inline:  # within the transaction: no other writer removes the file
                _write_file(self._file(tag), content)
            row = name, tag, written, media_type, cache_control, content if inline else None
            connection.execute(
                "INSERT OR REPLACE INTO objects VALUES (?, ?, ?, ?, ?, ?, ?)", (self._bucket, *row)
            )
        if before not in (tag, None):
            self._remove_files([before])
        return True

    def purge_all_versions(self, names: Iterable[str]) -> int:
        """Delete the objects; return their number. There are no earlier versions."""
        tags = []
        with self._database.writing() as connection:
            for name in names:
                if tag := self._tag(name):
                    tags.append(tag)
                    connection.execute(
                        "DELETE FROM objects WHERE bucket = ? AND name = ?", (self._bucket, name)
                    )
        self._remove_files(tags)
        return len(tags)

    def _row(self, columns: str, name: str) -> Any:
        query = f"SELECT {columns} FROM objects WHERE bucket = ? AND name = ?"  # noqa: S608
        rows = self._database.rows(query, self._bucket, name)
        return rows[0] if rows else None

    def _tag(self, name: str) -> str | None:
        row = self._row("tag", name)
        return row[0] if row else None

    def _file(self, tag: str) -> Path:
        assert self._database.folder is not None  # noqa: S101 - in memory everything is inline
        return self._database.folder / FOLDER_NAME / tag

    def _remove_files(self, tags: Iterable[str]) -> None:
        if self._database.folder is None:
            return
        for file in map(self._file, tags):
            if not file.exists():
                continue
            with self._database.writing():  # no other writer may begin to use it
                if not self._database.rows("SELECT 1 FROM objects WHERE tag = ?", file.name):
                    file.unlink(missing_ok=True)


@dataclass(frozen=True)
class Job:
    """A queued job that is leased to a worker; `attempts` includes this one."""

    id: int
    name: JobName
    payload: bytes
    attempts: int


class SqliteJobs(Jobs):
    """`Jobs` in SQLite. Jobs that fail every time stay, with their error."""

    def __init__(self, database: Database, run: Callable[[JobName, bytes], bytes | None]) -> None:
        self._database = database
        self._run = run
        self.queued = threading.Event()
        """Set when a job was queued in this process."""

    def later(self, job: JobName, payload: bytes) -> None:
        self._database.change(
            "INSERT INTO jobs (name, payload, due) VALUES (?, ?, ?)", job, payload, self._database.clock()
        )
        self.queued.set()

    def now(self, job: JobName, payload: bytes) -> bytes | None:
        return self._run(job, payload)

    def take(self, lease_s: float) -> Job | None:
        """Lease the oldest job that is due, unless another one is leased; None if there is none."""
        now = self._database.clock()
        # A job that is due much later was queued before the clock was set back.
        due, times = "error IS NULL AND (due <= ? OR due > ?)", (now, now + _MAX_PAUSE_S)
        if not self._database.rows(f"SELECT 1 FROM jobs WHERE {due}", *times):  # noqa: S608
            return None
        rows = self._database.change(
            "UPDATE jobs SET leased = ?, attempts = attempts + 1 WHERE id = "  # noqa: S608
            f"(SELECT MIN(id) FROM jobs WHERE {due}) "
            "AND NOT EXISTS (SELECT 1 FROM jobs WHERE leased > ? AND leased <= ?) "
            "RETURNING id, name, payload, attempts",
            *(now + lease_s, *times, now, now + lease_s),
        )
        return Job(*rows[0]) if rows else None

    def finish(self, job: Job) -> None:
        """Delete a job that succeeded."""
        self._database.change("DELETE FROM jobs WHERE id = ?", job.id)

    def retry(self, job: Job, pause_s: float) -> None:
        """Release a job that failed, to run again after `pause_s`."""
        due = self._database.clock() + pause_s
        self._database.change("UPDATE jobs SET leased = 0, due = ? WHERE id = ?", due, job.id)

    def fail(self, job: Job, error: str) -> None:
        """Keep a job that failed every time."""
        self._database.change("UPDATE jobs SET leased = 0, error = ? WHERE id = ?", error, job.id)

    def release_all(self) -> None:
        """Release every lease: the process that had them is gone."""
        self._database.change("UPDATE jobs SET leased = 0 WHERE leased > 0")

    def unfinished(self) -> int:
        """Count the jobs that are queued, running, or waiting for a retry."""
        return len(self._database.rows("SELECT 1 FROM jobs WHERE error IS NULL"))


def backup(source: Path, target: Path) -> None:
    """Copy the data folder `source`, which may be in use, to the new folder `target`."""
    target.mkdir(parents=True)
    (target / FOLDER_NAME).mkdir()
    with (
        closing(sqlite3.connect(source / FILE_NAME, timeout=_BUSY_TIMEOUT_S)) as connection,
        closing(sqlite3.connect(target / FILE_NAME)) as copy,
    ):
        connection.backup(copy)
        tags = copy.execute("SELECT DISTINCT tag FROM objects WHERE content IS NULL").fetchall()
        for (tag,) in tags:
            try:
                content = (source / FOLDER_NAME / tag).read_bytes()
            except FileNotFoundError:  # deleted since: the copy is of a moment before
                copy.execute("DELETE FROM objects WHERE tag = ?", (tag,))
                copy.commit()
                continue
            _write_file(target / FOLDER_NAME / tag, content)


def item_checksum(pk: str, sk: str, item: str, ttl: int | None) -> int:
    """Compute the checksum of a row of `items`."""
    return zlib.crc32(f"{pk}\0{sk}\0{item}\0{ttl}".encode())


def _after(prefix: str) -> str:
    return prefix + "\U0010ffff"


def _write_file(path: Path, content: bytes) -> None:
    draft = path.with_name(f"{path.name}.{os.getpid()}.{threading.get_ident()}.new")
    with draft.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    draft.replace(path)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
