"""Storage of the toy deployment, answering boto3 in this process."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import boto3
from botocore.config import Config

from tests.aws.emulator.environment import set_variables
from tests.aws.emulator.intercept import intercepting
from tests.aws.emulator.journal import Journal
from tests.aws.emulator.storage import Storage
from tests.aws.emulator.template import load
from tests.helpers.stack.toy_stack import deploy

TABLE, BUCKET = "calibdb-things", "calibdb-files"


@contextmanager
def storage(place: Path, now: float | None = None, journal: Journal | None = None) -> Iterator[Storage]:
    template = load(deploy(place, {}), {})
    opened = journal or Journal(place / "data" / "journal.sqlite")
    store = Storage(opened, template.tables, template.buckets, time.time() if now is None else now)

    def service(name: str) -> Any:
        return lambda operation, request: store.handle(name, operation, request)

    with set_variables({}, embedded=True), intercepting({name: service(name) for name in ("dynamodb", "s3")}):
        try:
            yield store
        finally:
            store.close()


def dynamodb() -> Any:
    return boto3.client("dynamodb", config=Config(max_pool_connections=32))


def s3() -> Any:
    return boto3.client("s3")


def put(client: Any, pk: str, sk: str = "META", **attributes: Any) -> None:
    client.put_item(TableName=TABLE, Item={"pk": {"S": pk}, "sk": {"S": sk}, **attributes})


def get(client: Any, pk: str, sk: str = "META") -> Any:
    return client.get_item(TableName=TABLE, Key={"pk": {"S": pk}, "sk": {"S": sk}}).get("Item")
