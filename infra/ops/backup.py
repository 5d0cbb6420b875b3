"""Backups of a data folder: one tar file with the database as it was at one moment, and its secrets."""

import os
import tarfile
import tempfile
import time
from pathlib import Path

from calibdb.store.sqlite import FILE_NAME, FOLDER_NAME, backup
from infra.ops import OpsError
from infra.server.folder import lock_folder

_SECRETS = "secrets.json"
_PARTS = (FILE_NAME, FOLDER_NAME, _SECRETS)


def write_backup(folder: Path, file: Path) -> int:
    """Back up a folder, whose server may run, to a new file; return its size in bytes. Raises OpsError."""
    if not (folder / FILE_NAME).is_file():
        raise OpsError(f"{folder} does not contain {FILE_NAME}: it is not a data folder")
    if file.exists():
        raise OpsError(f"{file} exists")
    with tempfile.TemporaryDirectory(dir=file.resolve().parent, prefix=".backup-") as place:
        copy = Path(place) / "copy"
        backup(folder, copy)
        (copy / _SECRETS).write_bytes((folder / _SECRETS).read_bytes())
        draft = Path(place) / "backup.tar"
        draft.touch(mode=0o600)
        with tarfile.open(draft, "w") as archive:
            for part in _PARTS:
                archive.add(copy / part, part)
        with draft.open("rb") as written:
            os.fsync(written.fileno())
        draft.replace(file)
    return file.stat().st_size


def restore_backup(folder: Path, file: Path) -> Path | None:
    """Restore a backup to a folder without a running server; return where its previous content is now.

    Raises OpsError.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    locked = lock_folder(folder, 0.0)
    if locked is None:
        raise OpsError(f"{folder} is in use: stop its server first")
    try:
        with tempfile.TemporaryDirectory(dir=folder, prefix=".restore-") as place:
            try:
                with tarfile.open(file) as archive:
                    archive.extractall(place, filter="data")
            except (tarfile.TarError, OSError) as error:
                raise OpsError(f"{file} cannot be read: {error}") from error
            if not all((Path(place) / part).exists() for part in _PARTS):
                raise OpsError(f"{file} is not a backup of calibDB")
            before = [each for each in folder.iterdir() if each.name not in ("lock", Path(place).name)]
            previous = None
            if before:
                previous = folder / f"before-restore-{time.strftime('%Y%m%dT%H%M%SZ', time.gmtime())}"
                previous.mkdir()
                for each in before:
                    each.replace(previous / each.name)
            for part in _PARTS:
                (Path(place) / part).replace(folder / part)
    finally:
        os.close(locked)
    return previous
