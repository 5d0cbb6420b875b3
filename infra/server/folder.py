"""The data folder: its lock, its secrets, and its checks at the start."""

import fcntl
import hashlib
import os
import shutil
import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

from calibdb.store.sqlite import (
    FILE_NAME,
    FOLDER_NAME,
    Database,
    SchemaError,
    item_checksum,
)
from infra.server import secrets, write_ahead_log

KEYPOINTS, SITE = "keypoints", "site"
"""Buckets of objects: of everything measured, and of what everyone may read."""
LOCK_TIMEOUT_S = 5.0
"""Time for the processes of a server that was killed to end."""
_JOURNAL = "journal.sqlite"  # of the versions before SQLite was the database
_RESTORE = "restore a backup with `calibdb-ops --data {folder} restore FILE`"
_REPAIR = "Rebuild the index with `calibdb-ops --data {folder} reindex`, or " + _RESTORE


class FolderError(Exception):
    """The data folder cannot be used; the message says why and what to do."""


class Folder:
    """An open data folder, created if necessary and locked until `close`; None: in memory.

    `new_secrets`: replace the secrets. `as_worker`: the process that started this one has locked and checked
    the folder. `as_guest`: a server that has the folder in use has checked it.

    Raises FolderError or SecretsError if the folder cannot be used.
    """

    def __init__(
        self,
        path: Path | None,
        clock: Any = time.time,
        *,
        new_secrets: bool = False,
        as_worker: bool = False,
        as_guest: bool = False,
    ) -> None:
        self.path = path
        self.lock: int | None = None
        self.damage: list[str] = []
        """Sentences about damage that was found."""
        if path is None:
            self.database, self.secrets = Database(None, clock), secrets.generate()
            return
        try:
            path.mkdir(mode=0o700, parents=True, exist_ok=True)
            if not as_worker:
                self.lock = lock_folder(path, 0.0 if as_guest else LOCK_TIMEOUT_S)
                if self.lock is None and not as_guest:
                    raise FolderError(f"{path} is in use by another server")
                as_worker = self.lock is None
        except OSError as error:
            raise FolderError(f"{path} cannot hold the data: {error.strerror}") from error
        try:
            self._open(path, clock, new_secrets=new_secrets, as_worker=as_worker)
        except BaseException:
            self.close()
            raise

    def _open(self, path: Path, clock: Any, *, new_secrets: bool, as_worker: bool) -> None:
        file, secret_file = path / FILE_NAME, path / "secrets.json"
        exists = file.exists()
        if not exists and (path / _JOURNAL).exists():
            raise FolderError(
                f"{path} was written by a version before 0.1.0. Write its captures to files with that "
                "version, `calibdb-ops dump --private FILES`, and load them here, `calibdb-ops load FILES`"
            )
        if secret_file.exists() and (not exists or file.stat().st_size == 0):
            raise FolderError(
                f"{file} is missing or empty, but {secret_file.name} is there: "
                f"{_RESTORE.format(folder=path)}, or move the whole folder away to start empty"
            )
        if new_secrets and secret_file.exists() and not as_worker:
            secret_file.replace(secret_file.with_suffix(".old"))
        self.secrets = secrets.load(secret_file, known=exists and not new_secrets)
        try:
            if exists and not as_worker:
                self._check(file)
            if not exists:
                os.close(os.open(file, os.O_CREAT | os.O_RDWR, 0o600))
            self.database = Database(path, clock)
        except SchemaError as error:
            raise FolderError(str(error)) from error
        except (sqlite3.Error, OSError) as error:
            raise FolderError(f"{file} cannot be opened ({error}): {_RESTORE.format(folder=path)}") from error

    def _check(self, file: Path) -> None:
        """Look for damage; raises FolderError if the database cannot be read."""
        folder = file.parent
        lost = write_ahead_log.lost_commits(file.with_name(f"{file.name}-wal"))
        if lost:
            copy = _copy_aside(file)
            self.damage.append(
                f"the log of {file} was damaged: {lost} of the last writes are lost. The damaged files are "
                f"in {copy.name}. {_REPAIR.format(folder=folder)}"
            )
        with closing(sqlite3.connect(file, timeout=10, isolation_level=None)) as connection:
            version = connection.execute("PRAGMA user_version").fetchone()[0]
            try:
                messages = [row[0] for row in connection.execute("PRAGMA quick_check(3)")]
            except sqlite3.DatabaseError as error:
                messages = [str(error)]
            if messages != ["ok"]:
                raise FolderError(f"{file} is damaged ({messages[0]}): {_RESTORE.format(folder=folder)}")
            if version != 1:
                return  # empty, or refused by the adapter
            items = list(_damaged_items(connection))
            objects = list(_damaged_objects(connection, folder))
            if not items and not objects:
                return
            copy = _copy_aside(file)
            connection.execute("BEGIN IMMEDIATE")
            connection.executemany("DELETE FROM items WHERE pk = ? AND sk = ?", items)
            connection.executemany("DELETE FROM objects WHERE rowid = ?", [(row,) for row, _ in objects])
            connection.execute("COMMIT")
        names = ", ".join([" ".join(map(str, key)) for key in items[:2]] + [name for _, name in objects[:3]])
        self.damage.append(
            f"{file}: {len(items)} items and {len(objects)} objects are damaged and were removed ({names}). "
            f"The damaged file is in {copy.name}. {_REPAIR.format(folder=folder)}"
        )

    def close(self) -> None:
        """Close the database and unlock the folder."""
        if hasattr(self, "database"):
            self.database.close()
        if self.lock is not None:
            os.close(self.lock)
            self.lock = None


def lock_folder(path: Path, timeout_s: float) -> int | None:
    """Lock the folder; None if another process keeps it locked."""
    descriptor = os.open(path / "lock", os.O_CREAT | os.O_RDWR, 0o600)
    end = time.monotonic() + timeout_s
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return descriptor
        except OSError:
            if time.monotonic() > end:
                os.close(descriptor)
                return None
            time.sleep(0.1)


def _copy_aside(file: Path) -> Path:
    copy = file.with_name(f"damaged-{time.strftime('%Y%m%dT%H%M%SZ', time.gmtime())}-{os.getpid()}")
    copy.mkdir()
    for suffix in ("", "-wal"):
        source = file.with_name(file.name + suffix)
        if source.exists():
            shutil.copy2(source, copy)
    return copy


def _damaged_items(connection: sqlite3.Connection) -> Iterator[tuple[Any, Any]]:
    for pk, sk, item, ttl, checksum in connection.execute("SELECT pk, sk, item, ttl, checksum FROM items"):
        try:
            if item_checksum(pk, sk, item, ttl) == checksum:
                continue
        except (TypeError, UnicodeError):
            pass
        yield pk, sk


def _damaged_objects(connection: sqlite3.Connection, folder: Path) -> Iterator[tuple[int, str]]:
    """Yield row and name of the objects whose content does not match its hash; remove unused files."""
    used = set()
    for row, name, tag, content in connection.execute("SELECT rowid, name, tag, content FROM objects"):
        if content is None:
            used.add(tag)
            try:
                content = (folder / FOLDER_NAME / str(tag)).read_bytes()
            except OSError:
                content = b""
        if not isinstance(content, bytes) or hashlib.sha256(content).hexdigest() != tag:
            yield row, str(name)
    for file in (folder / FOLDER_NAME).glob("*"):
        if file.name not in used:
            file.unlink()
