"""Interception of boto3: requests to the emulated services never leave this process.

botocore asks `before-send` handlers for a response before it opens a connection. moto's `mock_aws` would run
containers for Lambda.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO

from botocore.awsrequest import AWSPreparedRequest, AWSResponse
from botocore.compat import HTTPHeaders
from botocore.handlers import BUILTIN_HANDLERS

from tests.aws.emulator.storage import Answer

Service = Callable[[str, AWSPreparedRequest], Answer]
"""Operation and request to response."""


class _Raw(BytesIO):
    """A response body as botocore reads it from urllib3."""

    def stream(self, **_: object) -> Iterator[bytes]:
        while chunk := self.read():
            yield chunk


_services: dict[str, Service] = {}


def _intercept(event_name: str, request: AWSPreparedRequest, **_: object) -> AWSResponse | None:
    """Handle the requests of every boto3 client of this process; inert unless services are set."""
    service, operation = event_name.split(".")[1:3]
    if service not in _services:
        return None
    answer = _services[service](operation, request)
    return AWSResponse(
        request.url, answer.status, HTTPHeaders.from_dict(dict(answer.headers)), _Raw(answer.body)
    )


# Clients copy this list when they are made. A client made before this line would talk to AWS.
BUILTIN_HANDLERS.append(("before-send", _intercept))


@contextmanager
def intercepting(services: Mapping[str, Service]) -> Iterator[None]:
    """Respond to the requests of these services ("dynamodb", "s3", "lambda") until the end of the block."""
    assert not _services, "a local stack is running in this process already"
    _services.update(services)
    try:
        yield
    finally:
        _services.clear()


@contextmanager
def wrapping(wrap: Callable[[str, Service], Service]) -> Iterator[None]:
    """Replace each service of the running stack by `wrap(name, service)` until the end of the block."""
    before = dict(_services)
    _services.update({name: wrap(name, service) for name, service in before.items()})
    try:
        yield
    finally:
        _services.update(before)
