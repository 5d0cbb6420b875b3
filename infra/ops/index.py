"""Scans and batch deletes of the whole table, which only operators do."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING

from calibdb.store.clients import available

if TYPE_CHECKING:
    from mypy_boto3_dynamodb import DynamoDBClient

Key = tuple[str, str]  # pk, sk

_MAX_BATCH_DELETES = 25  # of one BatchWriteItem
_RETRY_PAUSE_S = 0.2  # before unprocessed items are tried again


class Index:
    """Keys of all items, and the removal of many."""

    def __init__(self, client: Callable[[], DynamoDBClient], name: str) -> None:
        self._client = client
        self._name = name

    def keys(self, *prefixes: str) -> Iterator[Key]:
        """Yield the keys whose `pk` begins with one of `prefixes`. Reads the whole table."""
        with available():
            pages = self._client().get_paginator("scan")
            for page in pages.paginate(TableName=self._name, ProjectionExpression="pk, sk"):
                for item in page["Items"]:
                    pk, sk = item["pk"]["S"], item["sk"]["S"]
                    if pk.startswith(prefixes):
                        yield pk, sk

    def sort_keys(self, pk: str, prefix: str) -> Iterator[str]:
        """Yield the `sk` of one partition that begin with `prefix`, in their order."""
        with available():
            pages = self._client().get_paginator("query")
            for page in pages.paginate(
                TableName=self._name,
                KeyConditionExpression="pk = :pk AND begins_with(sk, :prefix)",
                ExpressionAttributeValues={":pk": {"S": pk}, ":prefix": {"S": prefix}},
                ProjectionExpression="sk",
                ConsistentRead=True,
            ):
                yield from (item["sk"]["S"] for item in page["Items"])

    def remove(self, keys: Iterable[Key]) -> int:
        """Remove the items under these keys; return how many keys they were."""
        wanted = sorted(set(keys))
        for start in range(0, len(wanted), _MAX_BATCH_DELETES):
            left: dict[str, object] = {
                self._name: [
                    {"DeleteRequest": {"Key": {"pk": {"S": pk}, "sk": {"S": sk}}}}
                    for pk, sk in wanted[start : start + _MAX_BATCH_DELETES]
                ]
            }
            while left:
                with available():
                    answer = self._client().batch_write_item(RequestItems=left)  # type: ignore[arg-type]
                left = dict(answer.get("UnprocessedItems", {}))
                if left:
                    time.sleep(_RETRY_PAUSE_S)
        return len(wanted)
