"""The ports on AWS: DynamoDB, S3 and Lambda. No other module imports botocore.

Clients are botocore's: boto3 would add S3's transfer manager, a fifth of what a lookup imports.
"""

from __future__ import annotations

import functools
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from decimal import Decimal
from typing import TYPE_CHECKING, Any, cast

import botocore.session
from botocore.config import Config
from botocore.exceptions import BotoCoreError, ClientError

from calibdb.errors import DeniedReadError, UnavailableError
from calibdb.store.ports import Condition, Item, JobName, Jobs, Objects, Table, Value

if TYPE_CHECKING:
    from mypy_boto3_dynamodb import DynamoDBClient
    from mypy_boto3_dynamodb.type_defs import AttributeValueTypeDef
    from mypy_boto3_lambda import LambdaClient
    from mypy_boto3_s3 import S3Client
    from mypy_boto3_s3.type_defs import ObjectIdentifierTypeDef

# 409: another write of the same name is under way. It may still fail, so it is unknown if the name is taken.
_UNDECIDED = "ConditionalRequestConflict"
_MAX_WRITES = 5
_MAX_OBJECTS_PER_DELETE = 1000  # objects that S3 removes in one request
# Storage answers in milliseconds or not at all; the gateway gives up after 30 s, the function after 29.
_STORAGE = Config(
    connect_timeout=1,
    read_timeout=2,
    retries={"mode": "standard", "total_max_attempts": 3},
    tcp_keepalive=True,
)
# Reads of the secrets are retried, with pauses that spread a crowd.
_SECRETS = Config(connect_timeout=1, read_timeout=2, retries={"mode": "standard", "total_max_attempts": 1})
# A computation is asked for once: repeating it because it is slow would make it slower.
_INVOKE = Config(connect_timeout=1, read_timeout=25, retries={"mode": "standard", "total_max_attempts": 1})


_making = threading.Lock()  # a session is not safe to make clients with in several threads


@functools.cache
def dynamodb(region: str) -> DynamoDBClient:
    """Client of the index."""
    return cast("DynamoDBClient", _make("dynamodb", region, _STORAGE))


@functools.cache
def s3(region: str) -> S3Client:
    """Client of the bucket."""
    return cast("S3Client", _make("s3", region, _STORAGE))


@functools.cache
def lambda_(region: str) -> LambdaClient:
    """Client that asks other functions."""
    return cast("LambdaClient", _make("lambda", region, _INVOKE))


@functools.cache
def ssm(region: str) -> Any:
    """Client of the parameter store."""
    return _make("ssm", region, _SECRETS)


@functools.cache
def _session() -> botocore.session.Session:
    return botocore.session.get_session()


def _make(service: str, region: str, config: Config) -> Any:
    with _making:
        return _session().create_client(service, region_name=region, config=config)


def code(error: ClientError) -> str:
    """Return AWS's name of an error."""
    return error.response["Error"]["Code"]


@contextmanager
def available() -> Iterator[None]:
    """Turn what storage could not do, after its retries, into UnavailableError."""
    try:
        yield
    except (ClientError, BotoCoreError) as error:
        name = code(error) if isinstance(error, ClientError) else type(error).__name__
        raise UnavailableError(f"Storage did not answer ({name}).") from error


class DynamoTable(Table):
    """`Table` in DynamoDB."""

    def __init__(self, client: Callable[[], DynamoDBClient], name: str) -> None:
        self._client = client
        self._name = name

    def get(self, pk: str, sk: str, *, consistent: bool = True) -> Item | None:
        with available():
            response = self._client().get_item(
                TableName=self._name, Key=_key(pk, sk), ConsistentRead=consistent
            )
        return _decode(response["Item"]) if "Item" in response else None

    def put(self, item: Item, condition: Condition | None = None) -> bool:
        request = self._put_request(item) | _options(condition)
        return _attempt(self._client().put_item, **request) is not None

    def put_transaction(self, items: Sequence[Item], condition: Condition) -> bool:
        puts = [self._put_request(item) for item in items]
        puts[0] |= _options(condition)
        write = self._client().transact_write_items
        return _attempt(write, TransactItems=[{"Put": put} for put in puts]) is not None

    def _put_request(self, item: Item) -> dict[str, Any]:
        return {"TableName": self._name, "Item": {name: _encode(value) for name, value in item.items()}}

    def add(
        self, pk: str, sk: str, name: str, amount: int, *, limit: int | None = None, ttl: int | None = None
    ) -> int | None:
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
        changed = _attempt(
            self._client().update_item,
            TableName=self._name,
            Key=_key(pk, sk),
            UpdateExpression=update,
            ExpressionAttributeNames=names,
            ExpressionAttributeValues=values,
            ReturnValues="UPDATED_NEW",
            **options,
        )
        return None if changed is None else int(str(_decode(changed["Attributes"])[name]))

    def remove(self, pk: str, sk: str, name: str) -> None:
        _attempt(
            self._client().update_item,
            TableName=self._name,
            Key=_key(pk, sk),
            UpdateExpression="REMOVE #name",
            ConditionExpression="attribute_exists(pk)",
            ExpressionAttributeNames={"#name": name},
        )

    def delete(self, pk: str, sk: str, condition: Condition | None = None) -> bool:
        write = self._client().delete_item
        return _attempt(write, TableName=self._name, Key=_key(pk, sk), **_options(condition)) is not None

    def query(
        self,
        pk: str,
        prefix: str,
        *,
        newest_first: bool = False,
        limit: int | None = None,
        consistent: bool = False,
        after: str | None = None,
    ) -> list[Item]:
        items: list[Item] = []
        request: dict[str, Any] = {
            "TableName": self._name,
            "KeyConditionExpression": "pk = :pk AND begins_with(sk, :prefix)",
            "ExpressionAttributeValues": {":pk": {"S": pk}, ":prefix": {"S": prefix}},
            "ScanIndexForward": not newest_first,
            "ConsistentRead": consistent,
        }
        if after is not None:
            request["ExclusiveStartKey"] = _key(pk, after)
        while limit is None or len(items) < limit:
            if limit is not None:
                request["Limit"] = limit - len(items)
            with available():
                page = self._client().query(**request)
            items += map(_decode, page["Items"])
            if "LastEvaluatedKey" not in page:
                break
            request["ExclusiveStartKey"] = page["LastEvaluatedKey"]
        return items

    def keys(self, pk_prefix: str) -> Iterator[tuple[str, str]]:
        pages = self._client().get_paginator("scan")
        with available():
            for page in pages.paginate(
                TableName=self._name, ProjectionExpression="pk, sk", ConsistentRead=True
            ):
                for item in page["Items"]:
                    if item["pk"]["S"].startswith(pk_prefix):
                        yield item["pk"]["S"], item["sk"]["S"]


def _attempt(write: Callable[..., Any], **request: Any) -> Any:
    """Write and return the response; None if the condition fails, or another writes the same items."""
    with available():
        try:
            return write(**request)
        except ClientError as error:
            reasons = {str(r.get("Code")) for r in error.response.get("CancellationReasons", [])}
            overtaken = reasons <= {"None", "ConditionalCheckFailed", "TransactionConflict"}
            refused = code(error) == "ConditionalCheckFailedException"
            if refused or (code(error) == "TransactionCanceledException" and overtaken):
                return None
            raise


def _key(pk: str, sk: str) -> dict[str, AttributeValueTypeDef]:
    return {"pk": {"S": pk}, "sk": {"S": sk}}


def _options(condition: Condition | None) -> dict[str, Any]:
    if condition is None:
        return {}
    names: dict[str, str] = {}
    values: dict[str, Any] = {}
    alternatives = []
    for together in condition.alternatives:
        parts = []
        for each in together:
            names[f"#{each.name}"] = each.name
            if each.relation == "absent":
                parts.append(f"attribute_not_exists(#{each.name})")
            else:
                value = f":v{len(values)}"
                values[value] = _encode(each.value)
                parts.append(f"#{each.name} {each.relation} {value}")
        alternatives.append(" AND ".join(parts))
    options: dict[str, Any] = {
        "ConditionExpression": " OR ".join(alternatives),
        "ExpressionAttributeNames": names,
    }
    return options | ({"ExpressionAttributeValues": values} if values else {})


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
    raise ValueError(f"an attribute of a type that the index does not use: {sorted(value)}")


class S3Objects(Objects):
    """`Objects` in a bucket of S3."""

    def __init__(self, client: Callable[[], S3Client], bucket: str) -> None:
        self._client = client
        self._bucket = bucket

    def get_version(self, name: str) -> tuple[bytes, str] | None:
        with available():
            try:
                response = self._client().get_object(Bucket=self._bucket, Key=name)
                return response["Body"].read(), response["ETag"]
            except ClientError as error:
                # Without permission to list, S3 also returns 403 for a missing object.
                if code(error) == "AccessDenied":
                    self._confirm_missing(name)
                elif code(error) != "NoSuchKey":
                    raise
                return None

    def _confirm_missing(self, name: str) -> None:
        """Raise DeniedReadError unless the list of the bucket, which has another right, lacks the object."""
        try:
            listed = self._client().list_objects_v2(Bucket=self._bucket, Prefix=name, MaxKeys=1)
        except (ClientError, BotoCoreError) as error:
            raise DeniedReadError("Storage denied a read; try again.") from error
        if any(entry["Key"] == name for entry in listed.get("Contents", [])):
            raise DeniedReadError("Storage denied a read; try again.")

    def replace(self, name: str, content: bytes, tag: str) -> bool:
        refusals = ("PreconditionFailed", "NoSuchKey", _UNDECIDED)
        return self._write(name, content, refusals, IfMatch=tag) is None

    def create(self, name: str, content: bytes) -> bool:
        for _ in range(_MAX_WRITES):
            refusal = self._write(name, content, ("PreconditionFailed", _UNDECIDED), IfNoneMatch="*")
            if refusal != _UNDECIDED:
                return refusal is None
        raise UnavailableError("Other requests keep writing the same object; send this one again.")

    def put(
        self,
        name: str,
        content: bytes,
        media_type: str = "application/json",
        cache_control: str | None = None,
    ) -> None:
        options = {"CacheControl": cache_control} if cache_control else {}
        self._write(name, content, ContentType=media_type, **options)

    def _write(self, name: str, content: bytes, refusals: Sequence[str] = (), **options: Any) -> str | None:
        """Write an object; return the code with which S3 refused it if that is one of `refusals`."""
        with available():
            try:
                options = {"ContentType": "application/json", **options}
                self._client().put_object(Bucket=self._bucket, Key=name, Body=content, **options)
            except ClientError as error:
                if code(error) not in refusals:
                    raise
                return code(error)
        return None

    def purge_all_versions(self, names: Iterable[str]) -> int:
        removed = 0
        for name in names:
            versions = list(self._versions(name))
            self._delete([{"Key": name, "VersionId": version} for version in versions])
            removed += len(versions)
        return removed

    def _versions(self, name: str) -> Iterator[str]:
        with available():
            pages = self._client().get_paginator("list_object_versions")
            for page in pages.paginate(Bucket=self._bucket, Prefix=name):
                for entry in (*page.get("Versions", []), *page.get("DeleteMarkers", [])):
                    if entry["Key"] == name:  # others may begin with it
                        yield entry["VersionId"]

    def delete(self, names: Sequence[str]) -> None:
        self._delete([{"Key": name} for name in names])

    def _delete(self, objects: Sequence[ObjectIdentifierTypeDef]) -> None:
        for start in range(0, len(objects), _MAX_OBJECTS_PER_DELETE):
            batch = objects[start : start + _MAX_OBJECTS_PER_DELETE]
            with available():
                self._client().delete_objects(Bucket=self._bucket, Delete={"Objects": batch, "Quiet": True})

    def names(self, prefix: str, after: str = "") -> Iterator[str]:
        start: dict[str, Any] = {"StartAfter": after} if after else {}
        pages = self._client().get_paginator("list_objects_v2")
        with available():
            for page in pages.paginate(Bucket=self._bucket, Prefix=prefix, **start):
                for entry in page.get("Contents", []):
                    yield entry["Key"]


class LambdaJobs(Jobs):
    """`Jobs` as other functions; `functions`: their names, None for one that this function may not invoke."""

    def __init__(self, client: Callable[[], LambdaClient], functions: Mapping[JobName, str | None]) -> None:
        self._client = client
        self._functions = functions

    def later(self, job: JobName, payload: bytes) -> None:
        with available():
            self._client().invoke(FunctionName=self._name(job), InvocationType="Event", Payload=payload)

    def now(self, job: JobName, payload: bytes) -> bytes | None:
        with available():
            answer = self._client().invoke(
                FunctionName=self._name(job), InvocationType="RequestResponse", Payload=payload
            )
            content = answer["Payload"].read()
        return None if "FunctionError" in answer else content

    def _name(self, job: JobName) -> str:
        name = self._functions[job]
        if name is None:
            raise ValueError(f"{job.upper()}_FUNCTION is not set for a function that needs it")
        return name
