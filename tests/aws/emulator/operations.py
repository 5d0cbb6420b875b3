"""Operations of DynamoDB and S3 that read, and addresses that the others write. Pure.

An operation that is in neither list is refused: what it wrote would be lost in silence.
"""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote, urlsplit

from tests.aws.emulator.journal import OBJECT, Address

READS: Mapping[str, frozenset[str]] = {
    "dynamodb": frozenset(
        {
            "BatchGetItem",
            "DescribeTable",
            "DescribeTimeToLive",
            "GetItem",
            "ListTables",
            "Query",
            "Scan",
            "TransactGetItems",
        }
    ),
    "s3": frozenset(
        {
            "GetBucketLocation",
            "GetBucketReplication",
            "GetObject",
            "HeadBucket",
            "HeadObject",
            "ListBuckets",
            "ListObjects",
            "ListObjectsV2",
        }
    ),
}

ItemAddress = Callable[[str, Mapping[str, Any]], Address]
"""Table and attributes in DynamoDB's JSON, the key at least, to an address."""


@dataclass(frozen=True)
class Call:
    """A request that a boto3 client was about to send."""

    service: str
    operation: str
    url: str
    body: bytes


def written_keys(call: Call, item_address: ItemAddress) -> tuple[Address, ...] | None:
    """Derive the addresses that a call may write, none for a read; None if the operation is not known."""
    if call.operation in READS[call.service]:
        return ()
    if call.service == "dynamodb":
        return _items(call, item_address)
    return _objects(call)


def _items(call: Call, item_address: ItemAddress) -> tuple[Address, ...] | None:
    asked = json.loads(call.body)
    match call.operation:
        case "PutItem":
            return (item_address(asked["TableName"], asked["Item"]),)
        case "UpdateItem" | "DeleteItem":
            return (item_address(asked["TableName"], asked["Key"]),)
        case "BatchWriteItem":
            return tuple(
                item_address(table, write.get("Item") or write.get("Key"))
                for table, entries in asked["RequestItems"].items()
                for entry in entries
                for write in entry.values()
            )
        case "TransactWriteItems":
            return tuple(
                item_address(write["TableName"], write.get("Item") or write.get("Key"))
                for entry in asked["TransactItems"]
                for write in entry.values()
            )
    return None


def _objects(call: Call) -> tuple[Address, ...] | None:
    bucket, key = bucket_and_key(call.url)
    match call.operation:
        case "PutObject" | "CopyObject" | "DeleteObject":
            return (Address(OBJECT, bucket, key),)
        case "DeleteObjects":
            # botocore in this process wrote this document a moment ago.
            document = ET.fromstring(call.body)
            keys = (element.text for element in document.iter() if element.tag.rpartition("}")[2] == "Key")
            return tuple(Address(OBJECT, bucket, key) for key in keys if key)
    return None


def bucket_and_key(url: str) -> tuple[str, str]:
    """Split a virtual-hosted (bucket.s3.region…/key) or path-style (s3.region…/bucket/key) address."""
    parts = urlsplit(url)
    host, path = parts.hostname or "", unquote(parts.path).removeprefix("/")
    bucket, virtual, _ = host.partition(".s3.")
    if virtual:
        return bucket, path
    bucket, _, key = path.partition("/")
    return bucket, key
