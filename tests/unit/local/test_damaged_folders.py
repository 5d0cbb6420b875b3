"""Damaged data folders: said in one sentence, never taken for empty, and what is undamaged is served."""

import random
import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from infra.local import salvage, secrets
from infra.local.journal import ITEM, OBJECT, Address, Change, Content, Journal, JournalError
from infra.local.secrets import SecretsError
from infra.local.stack import LocalStack

RECORDS = 120
Damage = Callable[[Path, random.Random], None]


def record(n: int) -> Change:
    kind, container = (ITEM, "calibdb") if n % 2 else (OBJECT, "calibdb-keypoints")
    body = (f'{{"n": {n}, "text": "' + "x" * (40 + 97 * n % 6000) + '"}').encode()
    return Change(Address(kind, container, f"key-{n:03d}"), Content(body, '{"modified": 1.0}'))


@pytest.fixture(scope="module")
def undamaged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("undamaged") / "data"
    journal = Journal(folder / "journal.sqlite")
    secrets.load(folder / "secrets.json")
    for n in range(RECORDS):
        journal.commit([record(n)])
    journal.close()
    return folder


@pytest.fixture
def folder(undamaged: Path, tmp_path: Path) -> Path:
    shutil.copytree(undamaged, tmp_path / "data")
    return tmp_path / "data"


def overwrite(path: Path, at: int, content: bytes) -> None:
    with path.open("r+b") as file:
        file.seek(at)
        file.write(content)


def truncate(share: float) -> Damage:
    def damage(path: Path, _: random.Random) -> None:
        with path.open("r+b") as file:
            file.truncate(int(path.stat().st_size * share))

    return damage


def random_bytes(count: int, pieces: int = 1) -> Damage:
    def damage(path: Path, rng: random.Random) -> None:
        for _ in range(pieces):
            overwrite(path, rng.randrange(200, path.stat().st_size - count), rng.randbytes(count))

    return damage


def zeroed_pages(count: int) -> Damage:
    def damage(path: Path, rng: random.Random) -> None:
        pages = path.stat().st_size // 4096
        for _ in range(count):
            overwrite(path, 4096 * rng.randrange(1, pages), bytes(4096))

    return damage


def flip_bit(path: Path, rng: random.Random) -> None:
    at = rng.randrange(4096, path.stat().st_size)
    byte = path.read_bytes()[at]
    overwrite(path, at, bytes([byte ^ 1 << rng.randrange(8)]))


DAMAGES: dict[str, Damage] = {
    "half": truncate(0.5),
    "nine tenths": truncate(0.9),
    "one page": truncate(0.01),
    "empty": truncate(0.0),
    "garbage header": lambda path, rng: overwrite(path, 0, rng.randbytes(100)),
    "zeroed header": lambda path, _: overwrite(path, 0, bytes(100)),
    "zeroed first page": lambda path, _: overwrite(path, 0, bytes(4096)),
    "missing": lambda path, _: path.unlink(),
    "all zero": lambda path, _: path.write_bytes(bytes(path.stat().st_size)),
    "a text": lambda path, _: path.write_text("not a database" * 100) and None,
    **{f"64 bytes, {n}": random_bytes(64) for n in range(6)},
    **{f"a kilobyte, {n}": random_bytes(1024, 3) for n in range(4)},
    **{f"zeroed page, {n}": zeroed_pages(1) for n in range(5)},
    **{f"zeroed pages, {n}": zeroed_pages(8) for n in range(3)},
    **{f"flipped bit, {n}": flip_bit for n in range(6)},
}


def contents(journal: Journal) -> dict[Address, Content | None]:
    return {change.address: change.content for kind in (ITEM, OBJECT) for change in journal.load(kind)}


@pytest.mark.parametrize("name", DAMAGES)
def test_damaged_journal_is_said_and_served_as_far_as_it_is_sound(
    folder: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(salvage, "MAX_PROBED_ROWS", 20 * RECORDS)  # that many take a second
    path = folder / "journal.sqlite"
    before = path.read_bytes()
    DAMAGES[name](path, random.Random(name))
    changed = not path.exists() or path.read_bytes() != before
    try:
        journal = Journal(path, known=True)
    except JournalError as error:
        assert str(path) in str(error)  # noqa: PT017
        assert "copy" in str(error)  # noqa: PT017
        assert "\n" not in str(error)  # noqa: PT017
        assert (
            name in {"one page", "empty", "missing", "all zero", "a text", "zeroed pages, 1"}
            or "header" in name
            or "first" in name
        )
        return
    found = contents(journal)
    assert found
    written = {record(n).address: record(n).content for n in range(RECORDS)}
    # Nothing that differs from what was written, and a word about what is not there.
    assert {address: written.get(address) for address in found} == found
    assert changed
    if len(found) < RECORDS:
        assert journal.damage
        assert all(str(path) in sentence and "copy" in sentence for sentence in journal.damage)
    # Damage of a place costs what lay there: pages of 4,096 bytes, of which a record has one or two.
    most = {"half": 0.8, "nine tenths": 0.4}.get(name, 0.35)
    assert len(found) >= (1 - most) * RECORDS, (name, len(found))
    journal.commit([record(RECORDS)])
    journal.close()
    again = Journal(path, known=True)
    assert contents(again).keys() == found.keys() | {record(RECORDS).address}
    again.close()


@pytest.mark.parametrize(
    "content", [None, b"", b"{}", b"[1]", b"null", b'{"session": 1}', b"\xff", b'{"session']
)
def test_damaged_or_missing_secrets_are_said_and_kept(folder: Path, content: bytes | None) -> None:
    path = folder / "secrets.json"
    path.unlink()
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(SecretsError, match=r"secrets\.json .*NEW_SECRETS=1"), LocalStack(folder):
        pass
    assert (path.read_bytes() if path.exists() else None) == content


def test_folder_in_the_place_of_the_secrets_is_said(folder: Path) -> None:
    (folder / "secrets.json").unlink()
    (folder / "secrets.json").mkdir()
    with pytest.raises(SecretsError, match=r"secrets\.json cannot be read"), LocalStack(folder):
        pass


@pytest.mark.parametrize("part", ["journal.sqlite", "both"])
def test_missing_journal_beside_secrets_is_no_beginning(folder: Path, part: str) -> None:
    (folder / "journal.sqlite").unlink()
    if part == "both":  # an empty one in its place
        (folder / "journal.sqlite").touch()
    with pytest.raises(JournalError, match="missing or empty"), LocalStack(folder):
        pass


def test_item_that_is_no_json_is_left_out_and_the_others_are_served(tmp_path: Path) -> None:
    data = tmp_path / "data"
    with LocalStack(data) as stack:
        count = stack.storage.restored if stack.storage else -1
    database: Any = sqlite3.connect(data / "journal.sqlite")
    with database:
        # As an earlier release wrote it: without a checksum.
        database.execute(
            "UPDATE state SET body = ?, checksum = NULL WHERE kind = 'item'", (b'{"pk": {"S": "\x01',)
        )
    database.close()
    with LocalStack(data) as stack:
        assert count == 0
        (sentence,) = stack.damage
        assert "1 damaged record" in sentence
        assert "journal.sqlite" in sentence


def test_journal_of_the_first_version_is_read_and_gets_checksums(folder: Path) -> None:
    path = folder / "journal.sqlite"
    database = sqlite3.connect(path)
    with database:
        database.execute("ALTER TABLE state DROP COLUMN checksum")
        database.execute("PRAGMA user_version = 1")
    database.close()
    journal = Journal(path, known=True)
    assert len(contents(journal)) == RECORDS
    journal.commit([record(3)])
    journal.close()
    database = sqlite3.connect(path)
    assert database.execute("SELECT count(checksum) FROM state").fetchone() == (1,)
    database.close()
