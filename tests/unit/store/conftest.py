"""Implementations of the ports, in memory: SQLite, and AWS as the template makes it.

`test_ports.py` holds both to the same behaviour, so that the tests of the stores need only one.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager

import boto3
import pytest

from calibdb.store import Calibrations, Objects, Table
from calibdb.store.aws import DynamoTable, S3Objects
from calibdb.store.sqlite import Database, SqliteObjects, SqliteTable
from tests.helpers.aws import account
from tests.helpers.marks import thorough

REGION = "eu-central-1"
#: unix time of SQLite, which hides what has expired
CLOCK = [0.0]


@contextmanager
def elsewhere(endpoint: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Another implementation than moto (`make verify ONLY=conformance`), left as it was found."""
    monkeypatch.setenv("AWS_ENDPOINT_URL", endpoint)
    yield
    s3, dynamodb = boto3.client("s3", REGION), boto3.client("dynamodb", REGION)
    for kept in s3.list_object_versions(Bucket="bucket").get("Versions", []):
        s3.delete_object(Bucket="bucket", Key=kept["Key"], VersionId=kept["VersionId"])
    for listed in s3.list_objects_v2(Bucket="bucket").get("Contents", []):
        s3.delete_object(Bucket="bucket", Key=listed["Key"])
    s3.delete_bucket(Bucket="bucket")
    dynamodb.delete_table(TableName="table")


@pytest.fixture
def aws(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "test")
    endpoint = os.environ.get("CONFORMANCE_ENDPOINT")
    with elsewhere(endpoint, monkeypatch) if endpoint else account():
        boto3.client("s3", REGION).create_bucket(
            Bucket="bucket", CreateBucketConfiguration={"LocationConstraint": REGION}
        )
        boto3.client("dynamodb", REGION).create_table(
            TableName="table",
            BillingMode="PAY_PER_REQUEST",
            AttributeDefinitions=[{"AttributeName": n, "AttributeType": "S"} for n in ("pk", "sk")],
            KeySchema=[
                {"AttributeName": "pk", "KeyType": "HASH"},
                {"AttributeName": "sk", "KeyType": "RANGE"},
            ],
        )
        yield


@pytest.fixture(params=["aws"] if "CONFORMANCE_ENDPOINT" in os.environ else ["sqlite", *thorough("aws")])
def adapter(request: pytest.FixtureRequest) -> str:
    if request.param == "aws":
        request.getfixturevalue("aws")
    return str(request.param)


@pytest.fixture
def database() -> Iterator[Database]:
    database = Database(None, lambda: CLOCK[0])
    yield database
    database.close()


@pytest.fixture
def table(adapter: str, database: Database) -> Table:
    if adapter == "sqlite":
        return SqliteTable(database)
    client = boto3.client("dynamodb", REGION)
    return DynamoTable(lambda: client, "table")


@pytest.fixture
def objects(adapter: str, database: Database) -> Objects:
    if adapter == "sqlite":
        return SqliteObjects(database, "bucket")
    client = boto3.client("s3", REGION)
    return S3Objects(lambda: client, "bucket")


@pytest.fixture
def calibrations(table: Table, objects: Objects) -> Calibrations:
    return Calibrations(table, objects)
