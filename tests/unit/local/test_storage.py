"""Storage: what is acknowledged stays, what is not durable is taken back, conditions hold under threads."""

import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import boto3
import pytest
from botocore.config import Config
from botocore.exceptions import ClientError
from moto.dynamodb.models.dynamo_type import Item
from moto.dynamodb.models.table import Table
from moto.s3.models import FakeKey

from infra.local.environment import applied
from infra.local.intercept import intercepting
from infra.local.journal import Change, Journal, JournalError
from infra.local.storage import Storage
from infra.local.template import load
from tests.toy_stack import deploy

TABLE, BUCKET = "calibdb-things", "calibdb-files"


@contextmanager
def storage(place: Path, now: float | None = None, journal: Journal | None = None) -> Iterator[Storage]:
    template = load(deploy(place, {}), {})
    opened = journal or Journal(place / "data" / "journal.sqlite")
    store = Storage(opened, template.tables, template.buckets, time.time() if now is None else now)

    def service(name: str) -> Any:
        return lambda operation, request: store.handle(name, operation, request)

    with applied({}, embedded=True), intercepting({name: service(name) for name in ("dynamodb", "s3")}):
        try:
            yield store
        finally:
            store.close()


def dynamodb() -> Any:
    return boto3.client("dynamodb", config=Config(max_pool_connections=32))


def s3() -> Any:
    return boto3.client("s3")


def put(client: Any, pk: str, sk: str = "META", **attributes: Any) -> None:
    client.put_item(TableName=TABLE, Item={"pk": {"S": pk}, "sk": {"S": sk}, **attributes})


def get(client: Any, pk: str, sk: str = "META") -> Any:
    return client.get_item(TableName=TABLE, Key={"pk": {"S": pk}, "sk": {"S": sk}}).get("Item")


def test_items_and_objects_survive_in_all_their_types(tmp_path: Path) -> None:
    attributes = {
        "text": {"S": "Käm\u0000era"},
        "number": {"N": "1795232229.25"},
        "bytes": {"B": b"\x00\xff"},
        "flag": {"BOOL": True},
        "nothing": {"NULL": True},
        "names": {"SS": ["a", "b"]},
        "numbers": {"NS": ["1", "2"]},
        "list": {"L": [{"N": "1"}, {"L": [{"S": "x"}]}, {"M": {"deep": {"B": b"\x01\x02"}}}]},
        "map": {"M": {"in": {"M": {"er": {"BOOL": False}}}}},
    }
    with storage(tmp_path):
        put(dynamodb(), "a", **attributes)
        before = get(dynamodb(), "a")
        s3().put_object(
            Bucket=BUCKET,
            Key="a b+c/ü.json",
            Body=b"\x00body",
            ContentType="application/json",
            Metadata={"k": "v"},
        )
        object_before = s3().get_object(Bucket=BUCKET, Key="a b+c/ü.json")
        assert object_before["Body"].read() == b"\x00body"
    assert before == {"pk": {"S": "a"}, "sk": {"S": "META"}, **attributes}
    with storage(tmp_path) as store:
        assert store.restored == 2
        assert get(dynamodb(), "a") == before
        found = s3().get_object(Bucket=BUCKET, Key="a b+c/ü.json")
        assert found["Body"].read() == b"\x00body"
        for known in ("ContentType", "Metadata", "ETag", "LastModified", "ContentLength"):
            assert found[known] == object_before[known]


def test_updates_deletes_and_batches_survive(tmp_path: Path) -> None:
    with storage(tmp_path):
        client = dynamodb()
        for pk in "abcdef":
            put(client, pk, n={"N": "1"})
        client.update_item(
            TableName=TABLE,
            Key={"pk": {"S": "a"}, "sk": {"S": "META"}},
            UpdateExpression="ADD n :one",
            ExpressionAttributeValues={":one": {"N": "1"}},
        )
        client.delete_item(TableName=TABLE, Key={"pk": {"S": "b"}, "sk": {"S": "META"}})
        client.batch_write_item(
            RequestItems={
                TABLE: [
                    {"DeleteRequest": {"Key": {"pk": {"S": "c"}, "sk": {"S": "META"}}}},
                    {"PutRequest": {"Item": {"pk": {"S": "g"}, "sk": {"S": "META"}}}},
                ]
            }
        )
        client.transact_write_items(
            TransactItems=[
                {"Delete": {"TableName": TABLE, "Key": {"pk": {"S": "d"}, "sk": {"S": "META"}}}},
                {"Put": {"TableName": TABLE, "Item": {"pk": {"S": "h"}, "sk": {"S": "META"}}}},
            ]
        )
        files = s3()
        for key in ("x", "y", "z"):
            files.put_object(Bucket=BUCKET, Key=key, Body=key.encode())
        files.copy_object(Bucket=BUCKET, Key="copy", CopySource={"Bucket": BUCKET, "Key": "x"})
        files.delete_object(Bucket=BUCKET, Key="x")
        files.delete_objects(Bucket=BUCKET, Delete={"Objects": [{"Key": "y"}, {"Key": "absent"}]})
    with storage(tmp_path):
        items = dynamodb().scan(TableName=TABLE)["Items"]
        assert sorted(item["pk"]["S"] for item in items) == ["a", "e", "f", "g", "h"]
        assert get(dynamodb(), "a")["n"] == {"N": "2"}
        keys = [entry["Key"] for entry in s3().list_objects_v2(Bucket=BUCKET)["Contents"]]
        assert keys == ["copy", "z"]


def test_a_refused_condition_changes_nothing(tmp_path: Path) -> None:
    with storage(tmp_path):
        put(dynamodb(), "a", v={"N": "1"})
        with pytest.raises(ClientError, match="ConditionalCheckFailed"):
            dynamodb().put_item(
                TableName=TABLE,
                Item={"pk": {"S": "a"}, "sk": {"S": "META"}, "v": {"N": "2"}},
                ConditionExpression="attribute_not_exists(pk)",
            )
        s3().put_object(Bucket=BUCKET, Key="k", Body=b"1", IfNoneMatch="*")
        with pytest.raises(ClientError, match="PreconditionFailed"):
            s3().put_object(Bucket=BUCKET, Key="k", Body=b"2", IfNoneMatch="*")
    with storage(tmp_path):
        assert get(dynamodb(), "a")["v"] == {"N": "1"}
        assert s3().get_object(Bucket=BUCKET, Key="k")["Body"].read() == b"1"


def test_conditions_are_atomic_under_threads(tmp_path: Path) -> None:
    with storage(tmp_path):
        client = dynamodb()

        def claim(number: int) -> bool:
            try:
                client.put_item(
                    TableName=TABLE,
                    Item={"pk": {"S": f"claim{number % 20}"}, "sk": {"S": "META"}},
                    ConditionExpression="attribute_not_exists(pk)",
                )
            except ClientError:
                return False
            return True

        def count(_: int) -> None:
            client.update_item(
                TableName=TABLE,
                Key={"pk": {"S": "counter"}, "sk": {"S": "META"}},
                UpdateExpression="ADD n :one",
                ExpressionAttributeValues={":one": {"N": "1"}},
            )

        with ThreadPoolExecutor(16) as pool:
            claims = list(pool.map(claim, range(160)))
            list(pool.map(count, range(160)))
        assert sum(claims) == 20
    with storage(tmp_path):
        assert get(dynamodb(), "counter")["n"] == {"N": "160"}


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


def test_under_a_filling_disk_acknowledged_is_kept_and_refused_is_not(tmp_path: Path) -> None:
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
        self.gate.wait(10)
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
        writer.result(5)
        assert reader.result(5) is not None


def get_in_memory(pk: str) -> Any:
    from moto.dynamodb.models import dynamodb_backends

    table = dynamodb_backends["123456789012"]["us-east-1"].tables[TABLE]
    return next((item for item in Table.all_items(table) if item.hash_key.value == pk), None)


def test_those_who_wait_share_a_sync_and_reads_need_none(tmp_path: Path) -> None:
    journal = SlowJournal(tmp_path / "data" / "journal.sqlite")
    with storage(tmp_path, journal=journal), ThreadPoolExecutor(16) as pool:
        client = dynamodb()
        journal.gate.clear()
        writes = [pool.submit(put, client, str(number)) for number in range(16)]
        while get_in_memory("15") is None or len(journal.commits) > 0:
            time.sleep(0.001)
        time.sleep(0.05)
        journal.gate.set()
        for write in writes:
            write.result(5)
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


def test_what_could_not_be_journalled_is_refused(tmp_path: Path) -> None:
    with storage(tmp_path):
        with pytest.raises(ClientError, match="NotImplemented"):
            s3().create_multipart_upload(Bucket=BUCKET, Key="large")
        with pytest.raises(ClientError, match="NotImplemented"):
            dynamodb().execute_statement(Statement=f'INSERT INTO "{TABLE}" VALUE {{}}')
        with pytest.raises(ClientError, match="ValidationException"):
            dynamodb().put_item(TableName="no-such-table", Item={"pk": {"S": "a"}, "sk": {"S": "b"}})
        with pytest.raises(ClientError, match="ValidationException"):
            dynamodb().put_item(TableName=TABLE, Item={"pk": {"S": "a"}})


def test_expired_items_and_objects_are_not_restored(tmp_path: Path) -> None:
    now = time.time()
    with storage(tmp_path, now):
        put(dynamodb(), "session", ttl={"N": str(int(now) + 60)})
        put(dynamodb(), "calibration")
        for key in ("short/a", "long/a"):
            s3().put_object(Bucket=BUCKET, Key=key, Body=b"x")
    with storage(tmp_path, now + 30) as store:
        assert store.restored == 4
        assert get(dynamodb(), "session") is not None
    with storage(tmp_path, now + 3 * 86400):
        assert get(dynamodb(), "session") is None
        assert get(dynamodb(), "calibration") is not None
        assert [o["Key"] for o in s3().list_objects_v2(Bucket=BUCKET)["Contents"]] == ["long/a"]
    with storage(tmp_path, now) as store:
        assert store.restored == 2


def test_one_process_a_journal(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "journal.sqlite")
    with pytest.raises(JournalError, match="in use by another process"):
        Journal(tmp_path / "journal.sqlite")
    journal.close()
    Journal(tmp_path / "journal.sqlite").close()


def test_a_journal_of_another_release_is_refused(tmp_path: Path) -> None:
    import sqlite3

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
    changes = list(journal.load())
    journal.close()
    assert len(changes) == 3
    assert all(isinstance(change, Change) for change in changes)
    size = sum(file.stat().st_size for file in (tmp_path / "data").iterdir())
    assert size < 600 * 5000 / 10


def test_a_query_looks_at_its_partition_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with storage(tmp_path):
        client = dynamodb()
        for camera in range(5):
            for member in range(7):
                put(client, f"camera{camera}", f"CALIBRATION#{member}")
            put(client, f"camera{camera}", "CONSENSUS#1")

        def everything(_: Table) -> list[Item]:
            raise AssertionError("the whole table was looked at")

        monkeypatch.setattr(Table, "all_items", everything)
        found = client.query(
            TableName=TABLE,
            KeyConditionExpression="pk = :p AND begins_with(sk, :s)",
            ExpressionAttributeValues={":p": {"S": "camera3"}, ":s": {"S": "CALIBRATION#"}},
            ScanIndexForward=False,
            Limit=4,
        )
        assert [item["sk"]["S"] for item in found["Items"]] == [f"CALIBRATION#{n}" for n in (6, 5, 4, 3)]
        rest = client.query(
            TableName=TABLE,
            KeyConditionExpression="pk = :p AND begins_with(sk, :s)",
            ExpressionAttributeValues={":p": {"S": "camera3"}, ":s": {"S": "CALIBRATION#"}},
            ScanIndexForward=False,
            ExclusiveStartKey=found["LastEvaluatedKey"],
        )
        assert [item["sk"]["S"] for item in rest["Items"]] == [f"CALIBRATION#{n}" for n in (2, 1, 0)]


def test_nothing_that_was_is_held(tmp_path: Path) -> None:
    with storage(tmp_path):
        client, files = dynamodb(), s3()
        for number in range(20):
            put(client, "a", n={"N": str(number)})
            get(client, "a")
            files.put_object(Bucket=BUCKET, Key="a", Body=b"x" * 1000)
        assert Item.instances_tracked == []  # type: ignore[attr-defined]
        assert FakeKey.instances_tracked == []  # type: ignore[attr-defined]
