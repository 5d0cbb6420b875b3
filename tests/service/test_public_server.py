"""Hosts, pages and peers that a private server and one behind a proxy respond to."""

import json
import socket
import statistics
import time
from collections.abc import Iterator
from contextlib import suppress
from http.client import HTTPConnection
from pathlib import Path

import pytest

from calibdb.service import Service
from infra.server.app import Public, is_loopback
from infra.server.command import main
from infra.server.protocol import TimedProtocol
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


def opened(server: Server, token: str, origin: str | None = None, host: str = "127.0.0.1") -> int:
    headers = {"host": host, "authorization": f"Bearer {token}"} | ({"origin": origin} if origin else {})
    return request(server, "POST", "/v1/auth", headers).status


@pytest.mark.parametrize(
    ("origin", "status"),
    [
        (None, 201),
        ("http://127.0.0.1:8000", 201),
        ("http://localhost:5173", 201),
        ("http://localhost", 201),
        ("http://[::1]:1", 201),
        ("https://evil.example", 403),
        ("null", 403),
        ("http://localhost.evil.example:80", 403),
        ("http://127.0.0.1:99999", 403),
        ("http://[::1]:08000", 403),
    ],
)
def test_development_token_is_for_pages_of_this_machine(
    stack: Server, origin: str | None, status: int
) -> None:
    assert opened(stack, DEVELOPMENT_TOKEN, origin) == status


@pytest.mark.parametrize("path", ["/v1/cameras", "/config.json", "/", "/healthz"])
def test_request_for_another_host_is_misdirected(stack: Server, path: str) -> None:
    answer = request(stack, "GET", path, {"host": "evil.example:8000"})
    assert answer.status == 421
    assert b"cdb_" not in answer.body


def test_names_of_this_machine() -> None:
    mine = ("127.0.0.1", "127.1.2.3", "LOCALHOST:1", "[::1]:8000", "a.localhost")
    assert all(map(is_loopback, mine))
    foreign = ("", "localhost.", "localhost@evil.example", "127.0.0.1:80:80", "::1", "0.0.0.0")
    foreign += ("127.0.0.1.evil.example", "192.168.0.7:8000")
    assert not any(map(is_loopback, foreign))


def test_development_token_is_refused_and_the_pages_have_their_own(server: Server) -> None:
    token = json.loads(request(server, "GET", "/config.json", HOST).body)["token"]
    tried = [(DEVELOPMENT_TOKEN, None), (token, URL), (token, "https://elsewhere.example")]
    assert [opened(server, *each, HOST["host"]) for each in tried] == [403, 201, 403]


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
    assert answer.headers["access-control-allow-origin"] == "*"
    assert "PATCH" in answer.headers["access-control-allow-methods"]


def test_header_that_never_ends_is_cut_off(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    address = ("127.0.0.1", int(url.rpartition(":")[2]))
    kept = HTTPConnection(*address, timeout=60)
    for timeout_s in (60.0, 0.3):  # answered twice; then the next one is slow, within the time of the second
        monkeypatch.setattr(TimedProtocol, "header_timeout_s", timeout_s)
        kept.request("GET", "/healthz")
        assert kept.getresponse().read()
    fresh = [socket.create_connection(address, timeout=60) for _ in range(2)]
    took = []
    for connection, sent in zip(
        (*fresh, kept.sock), (b"", b"GET /healthz HTTP/1.1\r\nX: ", b"GET "), strict=True
    ):
        begun = time.monotonic()
        with connection, suppress(ConnectionError):  # a busy machine sends when it is cut off already
            connection.sendall(sent)
            while connection.recv(4096):
                pass
        took.append(time.monotonic() - begun)
    assert statistics.median(took) < 5 / 3, "s; one of three may be a pause of the machine"
