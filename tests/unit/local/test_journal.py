"""The journal: one process, one owner, and as large as what there is."""

import sqlite3
from pathlib import Path

import pytest

from infra.local.journal import ITEM, Journal, JournalError
from infra.local.server import PortInUseError, bind
from tests.helpers.stack.toy_storage import dynamodb, put, storage


def test_one_process_a_journal(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "journal.sqlite")
    with pytest.raises(JournalError, match="in use by another process"):
        Journal(tmp_path / "journal.sqlite")
    journal.close()
    Journal(tmp_path / "journal.sqlite").close()


def test_impossible_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("a file")
    with pytest.raises(JournalError, match="taken cannot hold the data"):
        Journal(tmp_path / "taken" / "journal.sqlite")


@pytest.mark.parametrize("port", [-1, 65536, 99999])
def test_impossible_port_is_named(port: int) -> None:
    with pytest.raises(PortInUseError, match=f"port {port} does not exist"):
        bind(port)


def test_a_journal_of_another_release_is_refused(tmp_path: Path) -> None:
    Journal(tmp_path / "journal.sqlite").close()
    connection = sqlite3.connect(tmp_path / "journal.sqlite")
    connection.execute("PRAGMA user_version = 99")
    connection.close()
    with pytest.raises(JournalError, match="version 99"):
        Journal(tmp_path / "journal.sqlite")


def test_the_journal_is_its_owners_alone(tmp_path: Path) -> None:
    Journal(tmp_path / "data" / "journal.sqlite").close()
    assert (tmp_path / "data").stat().st_mode & 0o077 == 0
    assert (tmp_path / "data" / "journal.sqlite").stat().st_mode & 0o077 == 0


def test_opening_costs_by_state_not_by_history(tmp_path: Path) -> None:
    with storage(tmp_path):
        client = dynamodb()
        for version in range(600):
            put(client, f"{version % 3}", version={"N": str(version)}, padding={"S": "x" * 5000})
    journal = Journal(tmp_path / "data" / "journal.sqlite")
    changes = list(journal.load(ITEM))
    journal.close()
    assert len(changes) == 3
    size = sum(file.stat().st_size for file in (tmp_path / "data").iterdir())
    assert size < 600 * 5000 / 10
