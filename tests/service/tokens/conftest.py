"""A stack behind an edge, a clock to turn, a client for each test, and hosts with proofs."""

import zlib
from collections.abc import Iterator

import pytest

from calibdb.proof import ProofError
from infra.server.server import Server
from tests.helpers.clock import Clock
from tests.helpers.service.client import Client
from tests.helpers.service.strangers import standing_clock


@pytest.fixture
def clock() -> Iterator[Clock]:
    """A service that remembers no token, at a time that a test says."""
    with standing_clock(token_ttl_s=0) as moved:
        yield moved


@pytest.fixture
def client(stack: Server, clock: Clock, request: pytest.FixtureRequest) -> Client:  # noqa: ARG001
    number = zlib.crc32(request.node.name.encode())
    return Client(stack, address=f"198.51.{number % 251}.{number // 251 % 251}")


@pytest.fixture
def site(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Proofs on hosts: text by name. Every other host has none."""
    files = {}

    def read_proof(host: str) -> str:
        if host not in files:
            raise ProofError("status")
        return files[host]

    monkeypatch.setattr("calibdb.proof.read_proof", read_proof)
    return files
