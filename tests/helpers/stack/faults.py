"""Storage that misbehaves: throttles, fails, keeps silent, or answers what was true a while ago."""

import functools
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
    def fault(_: Service, __: str, request: AWSPreparedRequest) -> Answer:
        raise ReadTimeoutError(endpoint_url=request.url)

    return fault


def unheard(_: str) -> Fault:
    def fault(service: Service, operation: str, request: AWSPreparedRequest) -> Answer:
        service(operation, request)
        raise ReadTimeoutError(endpoint_url=request.url)

    return fault


@contextmanager
def handled(handle: Callable[[str, Service, str, AWSPreparedRequest], Answer]) -> Iterator[None]:
    """Handle each request by its service's name, the service, and the operation; boto3 retries at once."""
    with pytest.MonkeyPatch.context() as patch:
        # Pauses between attempts are real seconds; that there are attempts is what matters here.
        patch.setattr(botocore.endpoint, "time", SimpleNamespace(sleep=lambda _: None))
        with wrapping(lambda name, service: functools.partial(handle, name, service)):
            yield


@contextmanager
def faulty(
    fault: Callable[[str], Fault],
    services: tuple[str, ...] = ("dynamodb", "s3"),
    share: float = 1.0,
    seed: int = 0,
) -> Iterator[list[str]]:
    """A share of the requests of these services go wrong; yields the operations that did."""
    rng, met = random.Random(seed), list[str]()

    def handle(name: str, service: Service, operation: str, request: AWSPreparedRequest) -> Answer:
        if name not in services or rng.random() >= share:
            return service(operation, request)
        met.append(operation)
        return fault(name)(service, operation, request)

    with handled(handle):
        yield met


@contextmanager
def stale() -> Iterator[list[str]]:
    """Reads that may be eventually consistent answer as they first did within the block."""
    first = {}
    met = []

    def handle(name: str, service: Service, operation: str, request: AWSPreparedRequest) -> Answer:
        body = request.body if isinstance(request.body, bytes) else b"{}"
        is_read = name == "dynamodb" and operation in ("GetItem", "Query")
        if not is_read or json.loads(body).get("ConsistentRead"):
            return service(operation, request)
        key = (operation, body)
        if key in first:
            met.append(operation)
        else:
            first[key] = service(operation, request)
        return first[key]

    with handled(handle):
        yield met


@contextmanager
def denied(which: Callable[[int], bool], *, listing: bool = False) -> Iterator[list[str]]:
    """S3 denies the reads whose number, from 0, is one of `which`; yields the paths of all reads.

    `listing`: it denies lists of the bucket, too.
    """
    lock = threading.Lock()
    met = []

    def handle(name: str, service: Service, operation: str, request: AWSPreparedRequest) -> Answer:
        is_denied = listing and name == "s3" and operation.startswith("ListObjects")
        if name == "s3" and operation == "GetObject":
            with lock:
                is_denied = which(len(met))
                met.append(request.url)
        return _error("s3", 403, "AccessDenied") if is_denied else service(operation, request)

    with handled(handle):
        yield met


@contextmanager
def watched_requests(stack: LocalStack) -> Iterator[set[str]]:
    """Nothing goes wrong; yields the paths of the CORS preflights that the gateway is sent."""
    met = set()
    handle = stack.gateway.handle

    def watching(request: Request) -> Response:
        if request.method == "OPTIONS":
            met.add(request.path)
        return handle(request)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stack.gateway, "handle", watching)
        yield met
