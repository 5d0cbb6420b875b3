"""Durable storage: a write is acknowledged once it is on disk, and undone if it cannot get there."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from botocore.exceptions import ClientError
from moto.dynamodb.models import dynamodb_backends
from moto.dynamodb.models.dynamo_type import DynamoType

from infra.local.intrinsics import ACCOUNT, REGION
from infra.local.journal import Journal
from tests.helpers.service.client import until
from tests.helpers.stack.toy_storage import BUCKET, TABLE, dynamodb, get, put, s3, storage


def test_a_full_disk_fails_the_write_and_takes_it_back(tmp_path: Path) -> None:
    with storage(tmp_path) as store:
        client = dynamodb()
        put(client, "before", v={"N": "1"})
        store.limit(1)  # fewer pages than there are: not one more can be had
        with pytest.raises(ClientError, match="InsufficientStorage"):
            put(client, "lost", v={"S": "x" * 100_000})
        with pytest.raises(ClientError, match="InsufficientStorage"):
            s3().put_object(Bucket=BUCKET, Key="lost", Body=b"x" * 100_000)
        with pytest.raises(ClientError, match="InsufficientStorage"):
            put(client, "before", v={"S": "y" * 100_000})
        # Memory says what disk says.
        assert get(client, "lost") is None
        assert get(client, "before")["v"] == {"N": "1"}
        assert "Contents" not in s3().list_objects_v2(Bucket=BUCKET)
        store.limit(1_000_000)
        put(client, "after")
    with storage(tmp_path):
        items = dynamodb().scan(TableName=TABLE)["Items"]
        assert sorted(item["pk"]["S"] for item in items) == ["after", "before"]


def test_filling_disk_keeps_acknowledged_writes_only(tmp_path: Path) -> None:
    with storage(tmp_path) as store:
        client = dynamodb()
        store.limit(60)

        def write(number: int) -> bool:
            try:
                put(client, f"{number}", v={"S": "x" * 3000})
            except ClientError:
                return False
            return True

        with ThreadPoolExecutor(16) as pool:
            kept = list(pool.map(write, range(200)))
        expected = {str(number) for number, ok in enumerate(kept) if ok}
        assert 0 < len(expected) < 200
        assert {item["pk"]["S"] for item in client.scan(TableName=TABLE)["Items"]} == expected
    with storage(tmp_path):
        assert {item["pk"]["S"] for item in dynamodb().scan(TableName=TABLE)["Items"]} == expected


class SlowJournal(Journal):
    """A journal whose commits wait until they are let through, and are counted."""

    def __init__(self, path: Path):
        super().__init__(path)
        self.gate = threading.Event()
        self.gate.set()
        self.commits: list[int] = []

    def commit(self, changes: Any) -> None:
        changes = list(changes)
        self.gate.wait(60)
        self.commits.append(len(changes))
        super().commit(changes)


def test_nobody_sees_a_write_before_it_is_durable(tmp_path: Path) -> None:
    journal = SlowJournal(tmp_path / "data" / "journal.sqlite")
    with storage(tmp_path, journal=journal), ThreadPoolExecutor(2) as pool:
        client = dynamodb()
        put(client, "other")
        journal.gate.clear()
        writer = pool.submit(put, client, "a")
        while get_in_memory("a") is None:
            time.sleep(0.001)
        reader = pool.submit(get, client, "a")
        time.sleep(0.1)
        assert not writer.done()
        assert not reader.done()
        journal.gate.set()
        writer.result(60)
        assert reader.result(60) is not None


def get_in_memory(pk: str) -> Any:
    table = dynamodb_backends[ACCOUNT][REGION].tables[TABLE]
    return table.items.get(DynamoType({"S": pk}))  # one look: writers insert meanwhile


def test_waiting_writes_share_one_sync(tmp_path: Path) -> None:
    journal = SlowJournal(tmp_path / "data" / "journal.sqlite")
    with storage(tmp_path, journal=journal), ThreadPoolExecutor(16) as pool:
        client = dynamodb()
        journal.gate.clear()
        writes = [pool.submit(put, client, str(number)) for number in range(16)]
        until(lambda: all(get_in_memory(str(number)) for number in range(16)))
        time.sleep(0.05)
        journal.gate.set()
        for write in writes:
            write.result(60)
        assert sum(journal.commits) == 16
        assert len(journal.commits) <= 3
        seen = len(journal.commits)
        for number in range(16):
            get(client, str(number))
        client.query(
            TableName=TABLE, KeyConditionExpression="pk = :p", ExpressionAttributeValues={":p": {"S": "1"}}
        )
        s3().list_objects_v2(Bucket=BUCKET)
        assert len(journal.commits) == seen
