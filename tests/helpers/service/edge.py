"""Answers at the edge as a test sees them, beside what lookups answer."""

import itertools
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import boto3
import pytest
from botocore.awsrequest import AWSPreparedRequest

from calibdb.schema import DISTORTION_MODELS
from calibdb.store.keys import answer_object
from infra.local import LocalStack, intercept
from infra.local.storage import Answer as StorageAnswer
from tests.helpers.service.client import TOKEN, Answer, Client

Size = tuple[int, int]


@dataclass(frozen=True)
class Question:
    """Everything that a lookup is about."""

    label: str
    platform: str
    img_size: Size
    model: str
    zoom: float = 0.0

    @property
    def object(self) -> str:
        return answer_object(self.label, self.platform, self.img_size, self.zoom, self.model)

    def ask(self, stack: LocalStack, token: str = TOKEN, address: str = "") -> Answer:
        return Client(stack, api_token=token, address=address).lookup(
            camera=self.label,
            platform=self.platform,
            img_size=self.img_size,
            zoom=self.zoom,
            distortion_model=self.model,
            redirect=False,
        )


def questions(
    labels: Iterable[str], platforms: Iterable[str], sizes: Iterable[Size] = ((1280, 720),)
) -> dict[str, Question]:
    """Every lookup that these make, by the name of the object that may answer it."""
    asked = (Question(*parts) for parts in itertools.product(labels, platforms, sizes, DISTORTION_MODELS))
    return {question.object: question for question in asked}


def objects(stack: LocalStack) -> dict[str, bytes]:
    """Everything under known/, once no asynchronous call may change it."""
    stack.wait_until_idle(60)
    assert stack.storage
    bucket = stack.environment["WEB_BUCKET_NAME"]
    pages = boto3.client("s3").get_paginator("list_objects_v2").paginate(Bucket=bucket, Prefix="known/")
    names = [entry["Key"] for page in pages for entry in page.get("Contents", [])]
    found = {name: stack.storage.read_object(bucket, name) for name in names}
    return {name: content[0] for name, content in found.items() if content}


def differences(stack: LocalStack, asked: dict[str, Question]) -> list[str]:
    """Objects that are not what a lookup answers, byte for byte."""
    wrong = []
    for name, content in objects(stack).items():
        if name not in asked:
            wrong.append(f"{name} answers nothing that was ever asked")
            continue
        answer = asked[name].ask(stack)
        if (answer.status, answer.body) != (200, content):
            wrong.append(f"{asked[name]}: {answer.status} {answer.body[:200]!r}, not {content[:200]!r}")
    return wrong


def let_locks_expire(stack: LocalStack) -> None:
    """Have half a minute pass, for the locks."""
    table = stack.environment["TABLE_NAME"]
    dynamodb = boto3.client("dynamodb")
    for item in dynamodb.scan(TableName=table, ProjectionExpression="pk, sk")["Items"]:
        if item["sk"]["S"] == "EDGE":
            dynamodb.delete_item(TableName=table, Key=item)


class KilledError(BaseException):
    """The process is no more. The server of a request alone catches it, to answer 500."""


@contextmanager
def killed_after(calls: int) -> Iterator[None]:
    """Let so many requests to storage pass within the block, and no other; nobody gets an answer then."""
    left = itertools.count(calls, -1)
    request = LocalStack.request
    killed = threading.Event()

    def around(name: str, service: intercept.Service) -> intercept.Service:
        def handle(operation: str, request: AWSPreparedRequest) -> StorageAnswer:
            if name != "lambda" and next(left) <= 0:
                killed.set()
                raise KilledError
            return service(operation, request)

        return handle

    def request_unless_killed(*given: Any, **named: Any) -> Any:
        answer = request(*given, **named)
        if killed.is_set():
            raise KilledError
        return answer

    with (
        pytest.MonkeyPatch.context() as patch,
        intercept.wrapping(around),
        suppress(KilledError),
    ):
        patch.setattr(LocalStack, "request", request_unless_killed)
        yield


def aliases(stack: LocalStack) -> list[dict[str, Any]]:
    """The items of all aliases."""
    items: Sequence[Any] = boto3.client("dynamodb").scan(TableName=stack.environment["TABLE_NAME"])["Items"]
    return [item for item in items if item["sk"]["S"].startswith("ALIAS#")]
