"""A server behind a proxy."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from calibdb.service import Service
from infra.server.app import Public
from infra.server.command import main
from infra.server.server import DEVELOPMENT_TOKEN, Server
from tests.helpers.service.commands import run
from tests.helpers.service.in_process import request

URL = "https://calibdb.example"
HOST = {"host": "calibdb.example"}
PROXIES = ("127.0.0.1/32", "10.0.0.0/8")


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    with Server(public=Public(URL, PROXIES)) as server:
        yield server


def opened(server: Server, token: str, origin: str | None = None) -> int:
    headers = {**HOST, "authorization": f"Bearer {token}"} | ({"origin": origin} if origin else {})
    return request(server, "POST", "/v1/auth", headers).status


def test_development_token_is_refused_and_the_pages_have_their_own(server: Server) -> None:
    token = json.loads(request(server, "GET", "/config.json", HOST).body)["token"]
    assert opened(server, DEVELOPMENT_TOKEN) == 403
    assert opened(server, token, URL) == 201
    assert opened(server, token, "https://elsewhere.example") == 403


def test_foreign_pages_create_no_tokens(server: Server) -> None:
    headers = {**HOST, "content-type": "application/json"}
    body = b'{"origins": ["https://page.example"]}'
    statuses = {
        origin: request(server, "POST", "/v1/tokens", headers | {"origin": origin}, body=body).status
        for origin in (URL, "https://elsewhere.example", "http://localhost")
    }
    assert statuses == {URL: 201, "https://elsewhere.example": 403, "http://localhost": 403}


@pytest.mark.parametrize(
    ("host", "status"),
    [
        ("calibdb.example", 200),
        ("CalibDB.example", 200),
        ("127.0.0.1:8000", 200),
        ("calibdb.example.evil", 421),
        ("calibdb.example:8000", 421),
    ],
)
def test_server_answers_to_its_own_names(server: Server, host: str, status: int) -> None:
    assert request(server, "GET", "/healthz", {"host": host}).status == status


@pytest.mark.parametrize(
    ("peer", "forwarded", "caller"),
    [
        ("127.0.0.1", "", "127.0.0.1"),
        ("127.0.0.1", "198.51.100.7", "198.51.100.7"),
        ("127.0.0.1", "203.0.113.9, 198.51.100.7", "198.51.100.7"),
        ("127.0.0.1", "203.0.113.9, 198.51.100.7, 10.1.2.3", "198.51.100.7"),
        ("127.0.0.1", "2001:db8::1", "2001:db8::1"),
        ("198.51.100.7", "203.0.113.9", "198.51.100.7"),
    ],
)
def test_address_comes_from_trusted_proxies_only(
    server: Server, monkeypatch: pytest.MonkeyPatch, peer: str, forwarded: str, caller: str
) -> None:
    addresses = []
    monkeypatch.setattr(Service, "source", lambda _, address: addresses.append(address) or address)
    headers = {**HOST, "content-type": "application/json", "x-forwarded-for": forwarded}
    request(server, "POST", "/v1/tokens", headers, body=b'{"origins": ["http://localhost"]}', client=peer)
    assert addresses == [caller]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--host", "0.0.0.0"], "--public-url is required"),
        (["--public-url", "https://calibdb.example/path"], "--public-url is an address"),
        (["--trusted-proxy", "nobody"], "nobody"),
        (["--port", "70000"], "port 70000 does not exist"),
    ],
)
def test_wrong_options_are_said_in_a_sentence(arguments: list[str], complaint: str, tmp_path: Path) -> None:
    assert complaint in run(main, "--data", tmp_path / "data", *arguments, status=1).err


def test_preflights_permit_what_pages_of_other_origins_send(server: Server) -> None:
    asked = {"origin": "https://page.example", "access-control-request-method": "POST"}
    answer = request(server, "OPTIONS", "/v1/lookup", HOST | asked)
    assert answer.status == 204
    allowed = {name: set(value.split(",")) for name, value in answer.headers.items()}
    assert allowed["access-control-allow-origin"] == {"*"}
    assert {"authorization", "content-type"} <= allowed["access-control-allow-headers"]
    assert {"GET", "POST", "PATCH", "DELETE"} <= allowed["access-control-allow-methods"]
