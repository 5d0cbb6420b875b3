"""Table and bucket in memory, as the template makes them."""

from collections.abc import Iterator

import boto3
import pytest
from moto import mock_aws

from calibdb.store import Objects, Table

REGION = "eu-central-1"


@pytest.fixture
def aws(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "test")
    with mock_aws():
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
