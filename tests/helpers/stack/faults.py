"""CORS preflights that an emulated gateway is sent."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from tests.aws.emulator import LocalStack
from tests.aws.emulator.events import Request
from tests.helpers.service.in_process import Response


@contextmanager
def watched_requests(stack: LocalStack) -> Iterator[set[str]]:
    """Yield the paths of the CORS preflights that the gateway is sent."""
    met = set()
    handle = stack.gateway.handle

    def watching(request: Request) -> Response:
        if request.method == "OPTIONS":
            met.add(request.path)
        return handle(request)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stack.gateway, "handle", watching)
        yield met
