"""Data folders: damage is reported in a sentence, nothing is lost silently, backups answer alike."""

import os
import random
import shutil
import sqlite3
import stat
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from calibdb.store.sqlite import (
    FILE_NAME,
    FOLDER_NAME,
    SCHEMA_VERSION,
    Database,
    SqliteObjects,
    SqliteTable,
)
from infra.ops.backup import write_backup
from infra.server import folder as folders
from infra.server.folder import KEYPOINTS, Folder, FolderError
from infra.server.secrets import SecretsError
from infra.server.server import Server
from infra.server.write_ahead_log import lost_commits
from tests.helpers.service.client import Client
from tests.helpers.service.commands import Operator
from tests.helpers.service.published import calibration, publish

ROWS = 120
#: random damages; all 100 with `DAMAGES=100`
DAMAGES = int(os.environ.get("DAMAGES", "8"))
LOG = f"{FILE_NAME}-wal"


def item(n: int) -> dict[str, Any]:
    return {"pk": f"CAMERA#{n % 7}", "sk": f"CALIBRATION#{n:03d}", "text": "x" * (97 * n % 3000), "n": n}


def content(n: int) -> bytes:
    return (f'{{"n": {n}}}'.encode()) * (1 + 97 * n % 400 if n else 300_000)


@pytest.fixture(scope="module")
def undamaged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder after a kill: half of its rows are in the log only."""
    made = tmp_path_factory.mktemp("undamaged") / "made"
    opened = Folder(made)
    table, objects = SqliteTable(opened.database), SqliteObjects(opened.database, KEYPOINTS)
    for n in range(ROWS):
        table.put(item(n))
        objects.put(f"calibrations/{n:03d}.json", content(n))
        if n == ROWS // 2:
            opened.database.rows("PRAGMA wal_checkpoint(TRUNCATE)")
    shutil.copytree(made, made.with_name("data"))
    opened.close()
    return made.with_name("data")


@pytest.fixture
def folder(undamaged: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(undamaged, tmp_path / "data"))


def missing(opened: Folder) -> int:
    """Number of rows that are not there; those that are, are as they were written."""
    table, objects = SqliteTable(opened.database), SqliteObjects(opened.database, KEYPOINTS)
    rows = []
    for n in range(ROWS):
        rows.append((table.get(str(item(n)["pk"]), str(item(n)["sk"])), item(n)))
        rows.append((objects.get(f"calibrations/{n:03d}.json"), content(n)))
    assert all(found in (None, written) for found, written in rows)
    return sum(found is None for found, _ in rows)


def test_killed_folder_is_whole(folder: Path) -> None:
    assert (folder / LOG).stat().st_size > 100_000
    assert lost_commits(folder / LOG) == 0
    with closing(Folder(folder)) as opened:
        assert (opened.damage, missing(opened)) == ([], 0)
    for name in (FILE_NAME, "secrets.json", "lock"):
        assert stat.S_IMODE((folder / name).stat().st_mode) == 0o600


def test_damage_anywhere_is_reported_and_the_rest_is_served(undamaged: Path, tmp_path: Path) -> None:
    rng = random.Random(1)
    said = refused = 0
    for number in range(DAMAGES):
        folder = Path(shutil.copytree(undamaged, tmp_path / str(number)))
        (large,) = (folder / FOLDER_NAME).iterdir()
        path = (folder / FILE_NAME, folder / LOG, large)[number % 3]
        damaged = bytearray(path.read_bytes())
        # Of the log's last frame, nothing tells damage from a write that was cut off.
        at = rng.randrange(len(damaged) - (3 * 4120 if path.name == LOG else 64))
        count = rng.choice([1, 8, 64])
        damaged[at : at + count] = rng.randbytes(count)
        path.write_bytes(damaged)
        try:
            opened = Folder(folder)
        except FolderError as error:
            refused += 1
            sentences = [str(error)]
        else:
            sentences = opened.damage
            said += bool(sentences)
            lost = missing(opened)
            opened.close()
            assert lost == 0 or sentences, (number, path.name, at, lost)
            with closing(Folder(folder)) as again:
                assert (again.damage, missing(again)) == ([], lost), "said once"
            shutil.rmtree(folder)
        assert all("restore" in sentence and "\n" not in sentence for sentence in sentences)
    assert said >= 0.3 * DAMAGES
    assert refused >= 1


def test_lost_commits_are_counted(folder: Path) -> None:
    log = bytearray((folder / LOG).read_bytes())
    log[32 + 24 + 100] ^= 1  # of the first frame
    (folder / LOG).write_bytes(log)
    lost = lost_commits(folder / LOG)
    assert lost == ROWS - 1 - ROWS // 2 + ROWS - 1 - ROWS // 2
    with closing(Folder(folder)) as opened:
        (sentence,) = opened.damage
    assert f"{lost} of the last writes are lost" in sentence
    (kept,) = folder.glob("damaged-*")
    assert (kept / LOG).read_bytes() == bytes(log)


@pytest.mark.parametrize("name", [FILE_NAME, "secrets.json"])
def test_missing_file_is_not_taken_for_a_beginning(folder: Path, name: str) -> None:
    (folder / name).unlink()
    with pytest.raises((FolderError, SecretsError), match="missing"):
        Folder(folder)


def test_newer_schema_is_refused(folder: Path) -> None:
    with closing(sqlite3.connect(folder / FILE_NAME)) as connection:
        connection.execute(f"PRAGMA user_version={SCHEMA_VERSION + 1}")
    with pytest.raises(FolderError, match="newer version"):
        Folder(folder)


def test_folder_that_cannot_be_used_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FolderError, match="cannot hold the data"):
        Folder(tmp_path / "file" / "data")


def test_second_server_is_refused_and_an_operator_is_a_guest(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folders, "LOCK_TIMEOUT_S", 0.1)
    with closing(Folder(folder)) as first:
        with pytest.raises(FolderError, match="in use by another server"):
            Folder(folder)
        with closing(Folder(folder, as_guest=True)) as guest:
            SqliteTable(guest.database).put({"pk": "P", "sk": "S"})
        assert SqliteTable(first.database).get("P", "S") is not None


def test_journal_of_earlier_versions_is_refused_with_the_way_on(tmp_path: Path) -> None:
    (tmp_path / "journal.sqlite").touch()
    with pytest.raises(FolderError, match=r"calibdb-ops dump --private FILES.*calibdb-ops load FILES"):
        Folder(tmp_path)


def test_expired_items_are_not_returned_and_swept() -> None:
    now = [1000.0]
    database = Database(None, lambda: now[0])
    table, objects = SqliteTable(database), SqliteObjects(database, KEYPOINTS)
    table.put({"pk": "P", "sk": "S", "ttl": 1100})
    table.put({"pk": "P", "sk": "T"})
    objects.put("sessions/a/1.json", b"1")
    objects.put("calibrations/a.json", b"1")
    assert len(table.query("P", "")) == 2
    now[0] = 1100.0
    assert [found["sk"] for found in table.query("P", "")] == ["T"]
    assert table.get("P", "S") is None
    assert table.add("P", "S", "n", 1) == 1, "a new item"
    table.put({"pk": "P", "sk": "S", "ttl": 1100})
    assert database.sweep({(KEYPOINTS, "sessions/"): 50.0}) == 2
    assert list(objects.names("")) == ["calibrations/a.json"]
    database.close()


def test_backup_of_a_running_server_answers_alike(tmp_path: Path, operator: Operator) -> None:
    backup, camera = tmp_path / "backup.tar", "Backed up"
    with Server(tmp_path / "running") as server:
        publish(server, *(calibration(camera, n) for n in range(5)))
        before = Client(server).lookup(camera=camera)
        assert before.status == 200
        write_backup(tmp_path / "running", backup)
    assert stat.S_IMODE(backup.stat().st_mode) == 0o600
    operator("restore", backup)
    with Server(operator.folder) as server:
        assert Client(server).lookup(camera=camera).json == before.json
        assert "in use" in operator("restore", backup, status=1)
    assert "exists" in operator("backup", backup, status=1)
    kept = operator.document("restore", backup)["before"]
    assert (Path(kept) / FILE_NAME).exists()


def open_files(path: Path) -> int:
    """Count the file descriptors of this process that are open on a file."""
    targets = (os.path.realpath(entry) for entry in Path("/proc/self/fd").iterdir())
    return sum(target == str(path) for target in targets)


def test_threads_of_requests_share_connections(tmp_path: Path) -> None:
    database, readers = Database(tmp_path), 4
    table = SqliteTable(database)
    table.put({"pk": "P", "sk": "S"})
    for _ in range(50):
        with ThreadPoolExecutor(readers) as threads:
            list(threads.map(lambda _: table.get("P", "S"), range(readers)))
    assert 1 <= open_files(tmp_path / FILE_NAME) <= readers
    database.close()
    assert open_files(tmp_path / FILE_NAME) == 0
