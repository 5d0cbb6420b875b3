"""The whole stack in memory, one for each module of tests, and a client of it."""

import functools
import ssl
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer.main

from calibdb.store import Store
from infra.server.server import Server
from tests.helpers.service import published
from tests.helpers.service.client import TOKEN, Client
from tests.helpers.service.commands import Operator
from tests.helpers.service.rigs import RigTruth
from tests.helpers.solver.computed_once import computed_once


@pytest.fixture(scope="session", autouse=True)
def certificates() -> Iterator[None]:
    """Certificates of this machine, read once: each HTTP client reads them for 20 ms."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ssl, "create_default_context", functools.cache(ssl.create_default_context))
        yield


@pytest.fixture(scope="session", autouse=True)
def commands() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", functools.cache(typer.main.get_command))
        yield


@pytest.fixture(scope="module", autouse=True)
def results_of_the_solver() -> Iterator[None]:
    with computed_once():
        yield


@pytest.fixture(scope="module")
def stack(request: pytest.FixtureRequest) -> Iterator[Server]:
    """A server with the `ENVIRONMENT` of the module, if it has one.

    It runs no jobs if the module says `JOBS = False`: it then computes no consensus.
    """
    worker = None if getattr(request.module, "JOBS", True) else 1
    with Server(environment=getattr(request.module, "ENVIRONMENT", {}), worker=worker) as stack:
        yield stack


@pytest.fixture(scope="module")
def store(stack: Server) -> Store:
    return published.store(stack)


@pytest.fixture(scope="module")
def url(stack: Server) -> Iterator[str]:
    with stack.serve() as url:
        yield url


@pytest.fixture
def served(url: str, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.setenv("CALIBDB_URL", url)
    monkeypatch.setenv("CALIBDB_TOKEN", TOKEN)
    return url


@pytest.fixture
def client(stack: Server) -> Client:
    return Client(stack)


@pytest.fixture
def running(client: Client) -> Client:
    assert client.open().status == 201
    return client


@pytest.fixture
def operator(tmp_path: Path) -> Operator:
    return Operator(tmp_path / "data")


@pytest.fixture(scope="module")
def finished_rig(stack: Server) -> RigTruth:
    rig = RigTruth(stack, seed=3).open()
    for moment in range(4):
        rig.moment(f"m{moment}")
    ended = rig.call("POST", "/finish")
    assert ended.status == 200, ended.body
    return rig
