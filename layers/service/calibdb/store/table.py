"""The index: one DynamoDB table of items under `pk` and `sk`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from typing import TYPE_CHECKING, Any

from botocore.exceptions import ClientError

from calibdb.store.clients import available, code

if TYPE_CHECKING:
    from collections.abc import Callable

    from mypy_boto3_dynamodb import DynamoDBClient
    from mypy_boto3_dynamodb.type_defs import AttributeValueTypeDef

Value = str | int | list[str]
Item = dict[str, Value]


@dataclass(frozen=True)
class Condition:
    """Condition on the stored item of a write; values are written `:name`."""

    expression: str
    values: Mapping[str, Value] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)


IF_NOT_EXISTS = Condition("attribute_not_exists(pk)")


class Table:
    """Reads and conditional writes of single items. Numbers are whole."""

    def __init__(self, client: Callable[[], DynamoDBClient], name: str) -> None:
        self._client = client
        self._name = name

    def get(self, pk: str, sk: str, *, consistent: bool = True) -> Item | None:
        """Return the item, None when there is none."""
        with available():
            found = self._client().get_item(
                TableName=self._name, Key={"pk": {"S": pk}, "sk": {"S": sk}}, ConsistentRead=consistent
            )
        return _decode(found["Item"]) if "Item" in found else None

    def put(self, item: Item, condition: Condition | None = None) -> bool:
        """Write the item; False, and nothing written, when `condition` does not hold."""
        with available():
            try:
                self._client().put_item(
                    TableName=self._name,
                    Item={k: _encode(v) for k, v in item.items()},
                    **_options(condition),
                )
            except ClientError as error:
                if code(error) != "ConditionalCheckFailedException":
                    raise
                return False
        return True

    def put_transaction(self, items: Sequence[Item], condition: Condition) -> bool:
        """Write all items or none; False, and nothing written, when `condition` does not hold of the first.

        Of two writers at once one is told False.
        """
        puts: list[dict[str, Any]] = [
            {"TableName": self._name, "Item": {k: _encode(v) for k, v in item.items()}} for item in items
        ]
        puts[0] |= _options(condition)
        writes: list[Any] = [{"Put": put} for put in puts]
        with available():
            try:
                self._client().transact_write_items(TransactItems=writes)
            except ClientError as error:
                if not _is_conditional_failure(error):
                    raise
                return False
        return True

    def add(
        self, pk: str, sk: str, name: str, amount: int, *, limit: int | None = None, ttl: int | None = None
    ) -> int | None:
        """Add to the counter `name` of an item, both made where there is none; return what it became.

        None, and nothing added, where it would exceed `limit`. An addition whose answer got lost is repeated
        and counts twice: for what need not be exact.
        """
        if limit is not None and amount > limit:
            return None
        names, values = {"#name": name}, {":amount": _encode(amount)}
        options: dict[str, Any] = {}
        update = "ADD #name :amount"
        if ttl is not None:
            update += " SET #ttl = :ttl"
            names["#ttl"], values[":ttl"] = "ttl", _encode(ttl)
        if limit is not None:
            options["ConditionExpression"] = "attribute_not_exists(#name) OR #name <= :room"
            values[":room"] = _encode(limit - amount)
        with available():
            try:
                changed = self._client().update_item(
                    TableName=self._name,
                    Key={"pk": {"S": pk}, "sk": {"S": sk}},
                    UpdateExpression=update,
                    ExpressionAttributeNames=names,
                    ExpressionAttributeValues=values,
                    ReturnValues="UPDATED_NEW",
                    **options,
                )
            except ClientError as error:
                if code(error) != "ConditionalCheckFailedException":
                    raise
                return None
        return int(str(_decode(changed["Attributes"])[name]))

    def remove(self, pk: str, sk: str, name: str) -> None:
        """Remove the attribute `name` of an item, if there is such an item."""
        with available():
            try:
                self._client().update_item(
                    TableName=self._name,
                    Key={"pk": {"S": pk}, "sk": {"S": sk}},
                    UpdateExpression="REMOVE #name",
                    ConditionExpression="attribute_exists(pk)",
                    ExpressionAttributeNames={"#name": name},
                )
            except ClientError as error:
                if code(error) != "ConditionalCheckFailedException":
                    raise

    def delete(self, pk: str, sk: str, condition: Condition | None = None) -> bool:
        """Remove the item, if there is one; False, and nothing removed, when `condition` does not hold."""
        with available():
            try:
                self._client().delete_item(
                    TableName=self._name, Key={"pk": {"S": pk}, "sk": {"S": sk}}, **_options(condition)
                )
            except ClientError as error:
                if code(error) != "ConditionalCheckFailedException":
                    raise
                return False
        return True

    def query(
        self,
        pk: str,
        prefix: str,
        *,
        newest_first: bool = False,
        limit: int | None = None,
        consistent: bool = False,
    ) -> list[Item]:
        """Return the items of `pk` whose `sk` begins with `prefix`, in the order of `sk` or against it.

        One Query for every megabyte of items.
        """
        return list(self._pages(pk, prefix, newest_first, limit, consistent))

    def page(self, pk: str, prefix: str, limit: int, after: str | None) -> tuple[list[Item], bool]:
        """Return at most `limit` items after the `sk` `after`, as `query` does, and whether more follow.

        One Query.
        """
        start: dict[str, Any] = (
            {} if after is None else {"ExclusiveStartKey": {"pk": {"S": pk}, "sk": {"S": after}}}
        )
        with available():
            found = self._client().query(
                TableName=self._name,
                KeyConditionExpression="pk = :pk AND begins_with(sk, :prefix)",
                ExpressionAttributeValues={":pk": {"S": pk}, ":prefix": {"S": prefix}},
                Limit=limit,
                **start,
            )
        return [_decode(item) for item in found["Items"]], "LastEvaluatedKey" in found

    def _pages(
        self, pk: str, prefix: str, newest_first: bool, limit: int | None, consistent: bool
    ) -> Iterator[Item]:
        options: dict[str, Any] = {}
        left = limit
        while left is None or left > 0:
            if left is not None:
                options["Limit"] = left
            with available():
                page = self._client().query(
                    TableName=self._name,
                    KeyConditionExpression="pk = :pk AND begins_with(sk, :prefix)",
                    ExpressionAttributeValues={":pk": {"S": pk}, ":prefix": {"S": prefix}},
                    ScanIndexForward=not newest_first,
                    ConsistentRead=consistent,
                    **options,
                )
            for item in page["Items"]:
                yield _decode(item)
            if left is not None:
                left -= len(page["Items"])
            if "LastEvaluatedKey" not in page:
                return
            options["ExclusiveStartKey"] = page["LastEvaluatedKey"]


def _is_conditional_failure(error: ClientError) -> bool:
    """Tell whether a transaction failed for its condition, or for another writer of the same items."""
    reasons = [str(r.get("Code")) for r in error.response.get("CancellationReasons", [])]
    return code(error) == "TransactionCanceledException" and set(reasons) <= {
        "None",
        "ConditionalCheckFailed",
        "TransactionConflict",
    }


def _options(condition: Condition | None) -> dict[str, Any]:
    if condition is None:
        return {}
    options: dict[str, Any] = {"ConditionExpression": condition.expression}
    if condition.values:
        options["ExpressionAttributeValues"] = {f":{k}": _encode(v) for k, v in condition.values.items()}
    if condition.names:
        options["ExpressionAttributeNames"] = {f"#{k}": v for k, v in condition.names.items()}
    return options


def _encode(value: Value) -> AttributeValueTypeDef:
    if isinstance(value, str):
        return {"S": value}
    if isinstance(value, int):
        return {"N": str(value)}
    return {"L": [{"S": text} for text in value]}


def _decode(item: Mapping[str, AttributeValueTypeDef]) -> Item:
    return {name: _value(value) for name, value in item.items()}


def _value(value: AttributeValueTypeDef) -> Value:
    if "S" in value:
        return value["S"]
    if "N" in value:
        return int(Decimal(value["N"]))
    if "L" in value:
        return [element["S"] for element in value["L"]]
    if "SS" in value:
        return sorted(value["SS"])
    raise ValueError(f"an attribute of a type that the index does not use: {sorted(value)}")
