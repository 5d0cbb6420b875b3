"""moto's DynamoDB and S3 as the template's tables and buckets, in memory."""

import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import boto3
from botocore.awsrequest import AWSPreparedRequest
from moto.core.botocore_stubber import BotocoreStubber
from moto.dynamodb.models import dynamodb_backends
from moto.s3.models import s3_backends

_TABLE_PROPERTIES = ("KeySchema", "AttributeDefinitions", "BillingMode")
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
        self.empty()

    def create(self, tables: Mapping[str, Mapping[str, Any]], buckets: Iterable[str]) -> None:
        """Create tables and buckets through boto3, whose requests `handle` receives."""
        for name, properties in tables.items():
            known = {key: properties[key] for key in _TABLE_PROPERTIES}
            boto3.client("dynamodb").create_table(TableName=name, **known)
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

    def empty(self) -> None:
        """Remove all tables and buckets."""
        with self._lock:
            dynamodb_backends.reset()
            s3_backends.reset()
