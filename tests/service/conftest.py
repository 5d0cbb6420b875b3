"""The whole stack in memory, one for each module of tests, and a client of it."""

import functools
import ssl
from collections.abc import Iterator

import pytest

from infra.server.server import Server
from tests.helpers.service.client import Client


@pytest.fixture(scope="session", autouse=True)
def certificates() -> Iterator[None]:
    """Certificates of this machine, read once: each HTTP client reads them for 20 ms."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ssl, "create_default_context", functools.cache(ssl.create_default_context))
        yield


@pytest.fixture(scope="module")
def stack(request: pytest.FixtureRequest) -> Iterator[Server]:
    """A server that runs no jobs if the module says `JOBS = False`: it then computes no consensus."""
    with Server(worker=None if getattr(request.module, "JOBS", True) else 1) as stack:
        yield stack


@pytest.fixture
def client(stack: Server) -> Client:
    return Client(stack)


@pytest.fixture
def running(client: Client) -> Client:
    """A client with a session of its own."""
    assert client.open().status == 201
    return client
