"""Table and bucket in memory, as the template makes them."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

import boto3
import pytest

from calibdb.store import Objects, Table
from tests.helpers.aws import account

REGION = "eu-central-1"


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


@pytest.fixture
def table(aws: None) -> Table:  # noqa: ARG001
    client = boto3.client("dynamodb", REGION)
    return Table(lambda: client, "table")


@pytest.fixture
def objects(aws: None) -> Objects:  # noqa: ARG001
    client = boto3.client("s3", REGION)
    return Objects(lambda: client, "bucket")
