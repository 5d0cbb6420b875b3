"""Interception of boto3: requests to the emulated services never leave this process.

botocore asks `before-send` handlers for a response before it opens a connection. This handler replaces moto's
`mock_aws`, because that also patches `requests` and the environment, and its Lambda runs containers.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO

from botocore.awsrequest import AWSPreparedRequest, AWSResponse
from botocore.compat import HTTPHeaders
from botocore.handlers import BUILTIN_HANDLERS
from moto.core.models import botocore_stubber

from tests.aws.emulator.storage import Answer

Service = Callable[[str, AWSPreparedRequest], Answer]
"""Operation and request to response."""


class _Interceptor:
    """The handler of every boto3 client of this process; inert unless services are set."""

    def __init__(self) -> None:
        self.services: Mapping[str, Service] = {}
        self.lock = threading.Lock()

    def __call__(self, event_name: str, request: AWSPreparedRequest, **_: object) -> AWSResponse | None:
        service, operation = event_name.split(".")[1:3]
        if service not in self.services:
            return None
        if botocore_stubber.enabled:
            raise RuntimeError("moto's mock_aws is active inside a local stack; both would respond")
        answer = self.services[service](operation, request)
        return AWSResponse(
            request.url, answer.status, HTTPHeaders.from_dict(dict(answer.headers)), _Raw(answer.body)
        )


class _Raw(BytesIO):
    """A response body as botocore reads it from urllib3."""

    def stream(self, **_: object) -> Iterator[bytes]:
        while chunk := self.read():
            yield chunk


_interceptor = _Interceptor()
# Clients copy this list when they are made. A client made before this line would talk to AWS.
BUILTIN_HANDLERS.append(("before-send", _interceptor))


@contextmanager
def intercepting(services: Mapping[str, Service]) -> Iterator[None]:
    """Respond to the requests of these services ("dynamodb", "s3", "lambda") until the end of the block.

    Raises
    ------
    RuntimeError
        If another stack runs: moto's backends and the environment belong to the process.
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
