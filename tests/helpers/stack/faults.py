"""Storage that misbehaves: throttles, fails, keeps silent, or answers what was true a while ago."""

import json
import random
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace

import botocore.endpoint
import pytest
from botocore.awsrequest import AWSPreparedRequest
from botocore.exceptions import ReadTimeoutError

from tests.aws.emulator import LocalStack
from tests.aws.emulator.events import Request, Response
from tests.aws.emulator.intercept import wrapping
from tests.aws.emulator.storage import Answer

Service = Callable[[str, AWSPreparedRequest], Answer]
Fault = Callable[[Service, str, AWSPreparedRequest], Answer]
_THROTTLED = {"dynamodb": (400, "ProvisionedThroughputExceededException"), "s3": (503, "SlowDown")}


def _error(service: str, status: int, code: str) -> Answer:
    if service == "s3":
        text = f"<Error><Code>{code}</Code><Message>rehearsed</Message></Error>"
        return Answer(status, {"content-type": "application/xml"}, text.encode())
    return Answer(status, {}, json.dumps({"__type": f"x#{code}", "message": "rehearsed"}).encode())


def throttled(name: str) -> Fault:
    return lambda _, __, ___: _error(name, *_THROTTLED[name])


def broken(name: str) -> Fault:
    return lambda _, __, ___: _error(
        name, 500, "InternalServerError" if name == "dynamodb" else "InternalError"
    )


def unreached(_: str) -> Fault:
    """The request is lost, and nothing happens."""

    def fault(_: Service, __: str, request: AWSPreparedRequest) -> Answer:
        raise ReadTimeoutError(endpoint_url=request.url)

    return fault


def unheard(_: str) -> Fault:
    """It is done, and the answer is lost."""

    def fault(service: Service, operation: str, request: AWSPreparedRequest) -> Answer:
        service(operation, request)
        raise ReadTimeoutError(endpoint_url=request.url)

    return fault


@contextmanager
def faulty(
    fault: Callable[[str], Fault],
    services: tuple[str, ...] = ("dynamodb", "s3"),
    share: float = 1.0,
    seed: int = 0,
) -> Iterator[list[str]]:
    """A share of the requests of these services go wrong; yields the operations that did."""
    rng, met = random.Random(seed), list[str]()

    def around(name: str, service: Service) -> Service:
        def handle(operation: str, request: AWSPreparedRequest) -> Answer:
            if rng.random() >= share:
                return service(operation, request)
            met.append(operation)
            return fault(name)(service, operation, request)

        return handle

    with wrapped_without_pauses(lambda name, s: around(name, s) if name in services else s):
        yield met


@contextmanager
def stale() -> Iterator[list[str]]:
    """Reads that may be eventually consistent answer as they first did within the block."""
    first: dict[tuple[str, bytes], Answer] = {}
    met: list[str] = []

    def around(dynamodb: Service) -> Service:
        def handle(operation: str, request: AWSPreparedRequest) -> Answer:
            body = request.body if isinstance(request.body, bytes) else b"{}"
            if operation not in ("GetItem", "Query") or json.loads(body).get("ConsistentRead"):
                return dynamodb(operation, request)
            key = (operation, body)
            if key in first:
                met.append(operation)
            return first.setdefault(key, first.get(key) or dynamodb(operation, request))

        return handle

    with wrapped_without_pauses(lambda name, s: around(s) if name == "dynamodb" else s):
        yield met


@contextmanager
def wrapped_without_pauses(wrap: Callable[[str, Service], Service]) -> Iterator[None]:
    """Wrap the services of the running stack; boto3 retries without its pauses."""
    with pytest.MonkeyPatch.context() as patch:
        # Pauses between attempts are real seconds; that there are attempts is what matters here.
        patch.setattr(botocore.endpoint, "time", SimpleNamespace(sleep=lambda _: None))
        with wrapping(wrap):
            yield


@contextmanager
def denied(which: Callable[[int], bool], *, listing: bool = False) -> Iterator[list[str]]:
    """S3 denies the reads whose number, from 0, is one of `which`; yields the paths of all reads.

    `listing`: it denies lists of the bucket, too.
    """
    lock = threading.Lock()
    met: list[str] = []

    def around(s3: Service) -> Service:
        def handle(operation: str, request: AWSPreparedRequest) -> Answer:
            if operation.startswith("ListObjects") and listing:
                return _error("s3", 403, "AccessDenied")
            if operation != "GetObject":
                return s3(operation, request)
            with lock:
                met.append(request.url)
                number = len(met) - 1
            return _error("s3", 403, "AccessDenied") if which(number) else s3(operation, request)

        return handle

    with wrapped_without_pauses(lambda name, s: around(s) if name == "s3" else s):
        yield met


@contextmanager
def watched_requests(stack: LocalStack) -> Iterator[set[str]]:
    """Nothing goes wrong; yields the paths of the CORS preflights that the gateway is sent."""
    met: set[str] = set()
    handle = stack.gateway.handle

    def watching(request: Request) -> Response:
        if request.method == "OPTIONS":
            met.add(request.path)
        return handle(request)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stack.gateway, "handle", watching)
        yield met
