"""Implementations of the ports, in memory: SQLite, and AWS as the template makes it.

`test_ports.py` holds both to the same behaviour, so that the tests of the stores need only one.
"""

import os
import uuid
from collections.abc import Iterator
from contextlib import nullcontext

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


@pytest.fixture
def aws(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Name of a bucket and a table of moto, or of `make verify ONLY=conformance`."""
    for variable in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(variable, "test")
    endpoint = os.environ.get("CONFORMANCE_ENDPOINT")
    if endpoint:
        monkeypatch.setenv("AWS_ENDPOINT_URL", endpoint)
    name = f"test-{uuid.uuid4()}"
    with nullcontext() if endpoint else account():
        boto3.client("s3", REGION).create_bucket(
            Bucket=name, CreateBucketConfiguration={"LocationConstraint": REGION}
        )
        boto3.client("dynamodb", REGION).create_table(
            TableName=name,
            BillingMode="PAY_PER_REQUEST",
            AttributeDefinitions=[{"AttributeName": n, "AttributeType": "S"} for n in ("pk", "sk")],
            KeySchema=[
                {"AttributeName": "pk", "KeyType": "HASH"},
                {"AttributeName": "sk", "KeyType": "RANGE"},
            ],
        )
        yield name


@pytest.fixture(params=["aws"] if "CONFORMANCE_ENDPOINT" in os.environ else ["sqlite", *thorough("aws")])
def adapter(request: pytest.FixtureRequest) -> str:
    """Name of a bucket and a table of AWS, or "sqlite"."""
    return str(request.getfixturevalue("aws") if request.param == "aws" else request.param)


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
    return DynamoTable(lambda: client, adapter)


@pytest.fixture
def objects(adapter: str, database: Database) -> Objects:
    if adapter == "sqlite":
        return SqliteObjects(database, "bucket")
    client = boto3.client("s3", REGION)
    return S3Objects(lambda: client, adapter)


@pytest.fixture
def calibrations(table: Table, objects: Objects) -> Calibrations:
    return Calibrations(table, objects)
