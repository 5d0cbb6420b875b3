"""The ports on AWS: what S3 and DynamoDB refuse, deny, or do not answer."""

from typing import Any
from unittest.mock import Mock

import boto3
import pytest
from botocore.exceptions import ClientError, ReadTimeoutError

from calibdb.errors import DeniedReadError, UnavailableError
from calibdb.store.aws import DynamoTable, S3Objects

REGION = "eu-central-1"


def error(code: str) -> ClientError:
    return ClientError({"Error": {"Code": code}}, "Operation")


def objects(**calls: Any) -> S3Objects:
    """Objects of a client that raises or returns these values."""
    client = Mock(**{name: Mock(side_effect=value) for name, value in calls.items()})
    return S3Objects(lambda: client, "bucket")


def test_purged_object_leaves_no_version(aws: str) -> None:
    client = boto3.client("s3", REGION)
    objects = S3Objects(lambda: client, aws)
    client.put_bucket_versioning(Bucket=aws, VersioningConfiguration={"Status": "Enabled"})
    for content in (b"1", b"2"):
        objects.put("a/b", content)
    objects.put("a/bc", b"3")
    objects.delete(["a/b"])
    assert objects.purge_all_versions(["a/b", "a/none"]) == 3  # two versions and the mark of the deletion
    left = client.list_object_versions(Bucket=aws)
    assert [found["Key"] for found in left["Versions"]] == ["a/bc"]


def create_amid(*codes: str) -> bool:
    """Create an object while S3 refuses with these codes, one for each attempt."""
    return objects(put_object=[*map(error, codes), None]).create("name", b"")


def test_conflicting_object_write_is_retried() -> None:
    """The other write may still fail: then both answers would say "written", and neither is there."""
    undecided = ["ConditionalRequestConflict"] * 3
    assert create_amid(*undecided) is True
    assert create_amid(*undecided, "PreconditionFailed") is False
    with pytest.raises(UnavailableError):
        create_amid(*undecided * 9)


@pytest.mark.parametrize(
    ("read", "listed"),
    [
        ("NoSuchKey", error("AccessDenied")),
        ("AccessDenied", {}),
        ("AccessDenied", {"Contents": [{"Key": "name.withdrawn"}]}),
    ],
)
def test_missing_object_is_none(read: str, listed: Any) -> None:
    assert objects(get_object=[error(read)], list_objects_v2=[listed]).get("name") is None


@pytest.mark.parametrize(
    "listed", [{"Contents": [{"Key": "name"}]}, error("AccessDenied"), ReadTimeoutError(endpoint_url="")]
)
def test_denied_read_is_not_a_missing_object(listed: Any) -> None:
    """S3 returns 403 for both unless the caller may list the bucket."""
    denied = objects(get_object=[error("AccessDenied")], list_objects_v2=[listed])
    with pytest.raises(DeniedReadError):
        denied.get("name")


@pytest.mark.parametrize("consistent", [True, False])
def test_reads_of_the_index_are_as_consistent_as_asked(consistent: bool) -> None:
    """Emulators always read what was written last."""
    client = Mock(get_item=Mock(return_value={}), query=Mock(return_value={"Items": []}))
    table = DynamoTable(lambda: client, "table")
    table.get("P", "S", consistent=consistent)
    table.query("P", "S", consistent=consistent)
    for call in (client.get_item, client.query):
        assert call.call_args.kwargs["ConsistentRead"] is consistent


@pytest.mark.parametrize(
    "failure", [error("ProvisionedThroughputExceededException"), ReadTimeoutError(endpoint_url="")]
)
def test_failure_of_the_index_is_unavailable(failure: Exception) -> None:
    fail = Mock(side_effect=failure)
    table = DynamoTable(lambda: Mock(get_item=fail, put_item=fail), "table")
    for call in (lambda: table.get("P", "S"), lambda: table.put({"pk": "P", "sk": "S"})):
        with pytest.raises(UnavailableError):
            call()


@pytest.mark.parametrize("failure", [error("SlowDown"), ReadTimeoutError(endpoint_url="")])
def test_failure_of_the_bucket_is_unavailable(failure: Exception) -> None:
    for call in (lambda bucket: bucket.get("name"), lambda bucket: bucket.create("name", b"")):
        with pytest.raises(UnavailableError):
            call(objects(get_object=failure, put_object=failure))
