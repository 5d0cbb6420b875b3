"""Interception of boto3: requests to the emulated services never leave this process.

botocore asks `before-send` handlers for an answer before it opens a connection, and tells them the operation;
moto itself hooks in there. A handler of our own instead of moto's `mock_aws`, because it must stand around
moto (lock, journal), because `mock_aws` also patches `requests` and the environment, and because a call in
flight must not be seen half done. Sockets between (moto's server, `AWS_ENDPOINT_URL`) would cost more than
the operations themselves.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO

from botocore import UNSIGNED
from botocore.awsrequest import AWSPreparedRequest, AWSResponse
from botocore.compat import HTTPHeaders
from botocore.handlers import BUILTIN_HANDLERS
from moto.core.models import botocore_stubber

from tests.aws.emulator.storage import Answer

Service = Callable[[str, AWSPreparedRequest], Answer]
"""Operation and request to answer."""


class _Interceptor:
    """The handler that every boto3 client of this process is made with; inert unless services are set."""

    def __init__(self) -> None:
        self.services: Mapping[str, Service] = {}
        self.lock = threading.Lock()

    def __call__(self, event_name: str, request: AWSPreparedRequest, **_: object) -> AWSResponse | None:
        service, operation = event_name.split(".")[1:3]
        if service not in self.services:
            return None
        if botocore_stubber.enabled:
            raise RuntimeError("moto's mock_aws is active inside a local stack; both would answer")
        answer = self.services[service](operation, request)
        return AWSResponse(
            request.url, answer.status, HTTPHeaders.from_dict(dict(answer.headers)), _Raw(answer.body)
        )


def _leave_unsigned(event_name: str, **_: object) -> object:
    """Let requests to the table go unsigned while they are answered here; moto's S3 wants a signature."""
    service = event_name.split(".")[1]
    return UNSIGNED if service == "dynamodb" and service in _interceptor.services else None


class _Raw(BytesIO):
    """A response body as botocore reads it from urllib3."""

    def stream(self, **_: object) -> Iterator[bytes]:
        while chunk := self.read():
            yield chunk


_interceptor = _Interceptor()
# Clients take their handlers from here when they are made, so this must happen before; a client made earlier
# would talk to AWS.
BUILTIN_HANDLERS += [("before-send", _interceptor), ("choose-signer", _leave_unsigned)]


@contextmanager
def intercepting(services: Mapping[str, Service]) -> Iterator[None]:
    """Answer the requests of these services ("dynamodb", "s3", "lambda") until the end of the block.

    Raises
    ------
    RuntimeError
        If it is being done already: moto's backends and the environment are the process's, so one stack at a
        time.
    """
    with _interceptor.lock:
        if _interceptor.services:
            raise RuntimeError("a local stack is running in this process already")
        _interceptor.services = services
    try:
        yield
    finally:
        _interceptor.services = {}


@contextmanager
def wrapping(wrap: Callable[[str, Service], Service]) -> Iterator[None]:
    """Replace each service of the running stack by `wrap(name, service)` until the end of the block."""
    services = _interceptor.services
    _interceptor.services = {name: wrap(name, service) for name, service in services.items()}
    try:
        yield
    finally:
        _interceptor.services = services
