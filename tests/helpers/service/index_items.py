"""The index of a stack, as its table holds it."""

from typing import Any

import boto3

from infra.local import LocalStack

Key = tuple[str, str]  # pk, sk


def items(stack: LocalStack) -> dict[Key, Any]:
    """All items of the table but for times, leases and counters, once no asynchronous call may change any."""
    stack.wait_until_idle(60)
    pages = boto3.client("dynamodb").get_paginator("scan").paginate(TableName=stack.environment["TABLE_NAME"])
    return {
        (item["pk"]["S"], item["sk"]["S"]): {k: v for k, v in item.items() if k != "ttl"}
        for page in pages
        for item in page["Items"]
        if not (item["sk"]["S"].startswith(("QUOTA#", "SHARE#")) or item["pk"]["S"].startswith("REFIT#"))
    }


def remove(stack: LocalStack, *keys: Key) -> None:
    table = boto3.client("dynamodb")
    for pk, sk in keys:
        table.delete_item(TableName=stack.environment["TABLE_NAME"], Key={"pk": {"S": pk}, "sk": {"S": sk}})
