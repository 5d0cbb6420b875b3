"""moto's DynamoDB and S3 as the template's tables and buckets, in memory."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import boto3
from botocore.awsrequest import AWSPreparedRequest
from moto.core.botocore_stubber import BotocoreStubber
from moto.dynamodb.models import dynamodb_backends
from moto.s3.models import s3_backends

from tests.aws.emulator.template import TableSpec

_TABLE_PROPERTIES = (
    "KeySchema",
    "AttributeDefinitions",
    "BillingMode",
    "GlobalSecondaryIndexes",
    "LocalSecondaryIndexes",
)
# What S3 answers for a missing object if the caller may not list the bucket, as no function may.
_DENIED = b"<Error><Code>AccessDenied</Code><Message>Access Denied</Message></Error>"


@dataclass(frozen=True)
class Answer:
    """The HTTP response of a service."""

    status: int
    headers: Mapping[str, str]
    body: bytes


class Storage:
    """Responses of DynamoDB and S3. One request at a time, because moto's writes are not atomic."""

    def __init__(self) -> None:
        self._moto = BotocoreStubber()
        self._lock = threading.RLock()
        self._reset()

    def create(self, tables: Iterable[TableSpec], buckets: Iterable[str]) -> None:
        """Create tables and buckets through boto3, whose requests `handle` receives."""
        for table in tables:
            properties = {
                name: table.properties[name] for name in _TABLE_PROPERTIES if name in table.properties
            }
            boto3.client("dynamodb").create_table(TableName=table.name, **properties)
        for bucket in buckets:
            boto3.client("s3").create_bucket(Bucket=bucket)

    def handle(self, operation: str, request: AWSPreparedRequest) -> Answer:
        """Respond to a request in the place of AWS."""
        with self._lock:
            response = self._moto.process_request(request)
        if response is None:
            return Answer(404, {}, b"")
        status, headers, body = response
        if operation == "GetObject" and status == 404:
            return Answer(403, {"content-type": "application/xml"}, _DENIED)
        return Answer(status, headers, body.encode() if isinstance(body, str) else body)

    def close(self) -> None:
        """Empty moto."""
        self._reset()

    def _reset(self) -> None:
        with self._lock:
            dynamodb_backends.reset()
            s3_backends.reset()
