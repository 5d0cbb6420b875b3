"""Storage: everything comes back after a restart, and conditions hold under threads."""

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from botocore.exceptions import ClientError
from moto.dynamodb.models.dynamo_type import Item
from moto.dynamodb.models.table import Table
from moto.s3.models import FakeKey

from tests.helpers.stack.toy_storage import BUCKET, TABLE, dynamodb, get, put, s3, storage


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


def test_a_refused_transaction_changes_nothing_and_copies_no_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with storage(tmp_path):
        client = dynamodb()
        for number in range(40):
            put(client, f"other {number}")
        for pk in "ab":
            put(client, pk, v={"N": "1"})
        copied: list[Item] = []
        deep = Item.__deepcopy__

        def copying(item: Item, memo: dict[int, object]) -> Item:
            copied.append(item)
            return deep(item, memo)

        monkeypatch.setattr(Item, "__deepcopy__", copying)
        key = {"TableName": TABLE, "Key": {"pk": {"S": "a"}, "sk": {"S": "META"}}}
        update = {"UpdateExpression": "ADD v :one", "ExpressionAttributeValues": {":one": {"N": "1"}}}
        writes = [
            {"Update": {**key, **update}},
            {"Delete": {"TableName": TABLE, "Key": {"pk": {"S": "b"}, "sk": {"S": "META"}}}},
            {"Put": {"TableName": TABLE, "Item": {"pk": {"S": "new"}, "sk": {"S": "META"}}}},
        ]
        absent = {"TableName": TABLE, "Key": {"pk": {"S": "absent"}, "sk": {"S": "META"}}}
        check = {"ConditionCheck": {**absent, "ConditionExpression": "attribute_exists(pk)"}}
        with pytest.raises(ClientError, match="TransactionCanceled"):
            client.transact_write_items(TransactItems=[*writes, check])
        there = [get(client, pk) for pk in ("a", "b", "new", "absent")]
        assert [item and item["v"] for item in there] == [{"N": "1"}, {"N": "1"}, None, None]
        client.transact_write_items(TransactItems=writes)
        assert len(copied) <= 4, "as many as are written, twice"
    with storage(tmp_path):
        there = [get(dynamodb(), pk) for pk in ("a", "b", "new")]
        assert [item and item.get("v") for item in there] == [{"N": "2"}, None, None]
        assert there[2] is not None


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


def test_unjournalled_write_is_refused(tmp_path: Path) -> None:
    with storage(tmp_path):
        with pytest.raises(ClientError, match="NotImplemented"):
            s3().create_multipart_upload(Bucket=BUCKET, Key="large")
        with pytest.raises(ClientError, match="NotImplemented"):
            dynamodb().execute_statement(Statement=f'INSERT INTO "{TABLE}" VALUE {{}}')
        with pytest.raises(ClientError, match="ValidationException"):
            dynamodb().put_item(TableName="no-such-table", Item={"pk": {"S": "a"}, "sk": {"S": "b"}})
        with pytest.raises(ClientError, match="ValidationException"):
            dynamodb().put_item(TableName=TABLE, Item={"pk": {"S": "a"}})


def test_every_object_has_one_removable_version(tmp_path: Path) -> None:
    def versions(prefix: str) -> list[tuple[str, str]]:
        pages = s3().get_paginator("list_object_versions").paginate(Bucket=BUCKET, Prefix=prefix)
        return [(found["Key"], found["VersionId"]) for page in pages for found in page.get("Versions", [])]

    with storage(tmp_path):
        for name in ("a/ü &<1>.json", "a/2.json", "b/3.json"):
            for body in (b"1", b"2"):
                s3().put_object(Bucket=BUCKET, Key=name, Body=body)
        assert versions("a/") == [("a/2.json", "null"), ("a/ü &<1>.json", "null")]
        wanted = [{"Key": key, "VersionId": version} for key, version in versions("a/")]
        s3().delete_objects(Bucket=BUCKET, Delete={"Objects": wanted})
    with storage(tmp_path):
        assert versions("") == [("b/3.json", "null")]


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


def test_overwritten_values_are_released(tmp_path: Path) -> None:
    with storage(tmp_path):
        client, files = dynamodb(), s3()
        for number in range(20):
            put(client, "a", n={"N": str(number)})
            get(client, "a")
            files.put_object(Bucket=BUCKET, Key="a", Body=b"x" * 1000)
        assert Item.instances_tracked == []  # type: ignore[attr-defined]
        assert FakeKey.instances_tracked == []  # type: ignore[attr-defined]


def test_missing_object_is_denied_as_to_whom_may_not_list(tmp_path: Path) -> None:
    """S3 does not tell a function that lacks the right to list that there is no such object."""
    with storage(tmp_path), pytest.raises(ClientError) as refused:
        s3().get_object(Bucket=BUCKET, Key="nowhere.json")
    assert refused.value.response["Error"]["Code"] == "AccessDenied"
    assert refused.value.response["ResponseMetadata"]["HTTPStatusCode"] == 403
