"""A kill at any moment."""

import json
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import pytest

from calibdb.store.ports import Storage
from infra.server.server import Server
from tests.helpers.service.client import Answer, Client
from tests.helpers.service.in_process import request
from tests.helpers.service.intercepted import WRITES, intercepted_service
from tests.helpers.service.stores import override_service
from tests.helpers.service.strangers import SITE, ask, make, manage


class KilledError(Exception):
    """The process ended here."""


@dataclass
class Process:
    """Process that is killed, and the number of its writes until then."""

    written: int = 0
    killed: bool = False


@dataclass
class Owner:
    client: Client
    made: Any = field(init=False)

    def __post_init__(self) -> None:
        self.made = make(self.client, "http://localhost", SITE)

    def manage(self, method: str, action: str = "", body: object = None) -> Answer:
        return manage(self.client, method, self.made, action, body)

    def send(self, method: str, action: str, body: object) -> int:
        """Send a request that nobody may live to answer; return its status."""
        headers = {"authorization": f"Bearer {self.made['management_token']}"}
        content = b"" if body is None else json.dumps(body).encode()
        return request(self.client.stack, method, f"/v1/tokens/self{action}", headers, body=content).status

    def lookup(self, token: str, origin: str | None = None) -> int:
        return ask(self.client, token, origin).status


@contextmanager
def killed_at(storage: Storage, number: int) -> Iterator[Process]:
    """Let the process end before its write of this number: nothing is written or read from there on."""
    process = Process()

    def around(operation: str, call: Callable[[], Any]) -> Any:
        process.killed = process.killed or (operation in WRITES and process.written == number)
        if process.killed:
            raise KilledError
        process.written += operation in WRITES
        return call()

    with intercepted_service(storage, around, token_ttl_s=0):
        yield process


@pytest.fixture(scope="module")
def stack() -> Iterator[Server]:
    with Server() as stack, override_service(token_ttl_s=0):
        yield stack


def rotated(owner: Owner, answer: Answer) -> None:
    assert owner.lookup(owner.made["token"]) == 200  # that is in use somewhere
    assert owner.lookup(answer.json["token"]) == 200


def verified(owner: Owner, answer: Answer) -> None:
    assert {origin["state"] for origin in answer.json["origins"]} == {"verified"}
    assert answer.json["plan"] == "free"
    assert owner.lookup(owner.made["token"], SITE) == 200


def changed(owner: Owner, answer: Answer) -> None:
    assert [origin["origin"] for origin in answer.json["origins"]] == ["http://127.0.0.1"]
    assert owner.lookup(owner.made["token"], "http://localhost") == 403
    assert owner.lookup(owner.made["token"], "http://127.0.0.1") == 200


def revoked(owner: Owner, answer: Answer) -> None:
    assert answer.status == 204
    assert owner.lookup(owner.made["token"]) == 403


@pytest.mark.parametrize(
    ("method", "action", "body", "holds"),
    [
        ("POST", "/rotate", None, rotated),
        ("POST", "/verify", None, verified),
        ("PATCH", "", {"origins": ["http://127.0.0.1"]}, changed),
        ("DELETE", "", None, revoked),
    ],
    ids=["rotate", "verify", "change", "revoke"],
)
def test_killed_before_any_write_and_asked_again(
    stack: Server,
    monkeypatch: pytest.MonkeyPatch,
    method: str,
    action: str,
    body: object,
    holds: Callable[[Owner, Answer], None],
) -> None:
    number = 0
    while True:
        owner = Owner(
            Client(stack, address=f"198.18.{zlib.crc32((action + method).encode()) % 200}.{number}")
        )
        line = f"calibdb-site-verification={owner.made['id']}"
        monkeypatch.setattr("calibdb.proof.read_proof", lambda _, line=line: line)
        with killed_at(stack.storage, number) as process:
            status = owner.send(method, action, body)
        assert status >= 500 if process.killed else status < 300
        if action == "/rotate":
            assert owner.lookup(owner.made["token"]) == 200
        holds(owner, owner.manage(method, action, body))
        if not process.killed:
            break
        number += 1
    assert number >= 3  # counted, stored, indexed


def test_killed_while_a_token_is_made_leaves_none_half_made(stack: Server) -> None:
    for number in range(4):
        client = Client(stack, address=f"198.19.0.{number}")
        headers = {"content-type": "application/json"}
        with killed_at(stack.storage, number) as process:
            body = b'{"origins": ["http://localhost"]}'
            request(stack, "POST", "/v1/tokens", headers, body=body, client=client.address)
        assert process.killed
        answer = client.call("POST", "/v1/tokens", {"origins": ["http://localhost"]}, token="")
        assert answer.status == 201
        assert client.call("GET", "/v1/usage", token=answer.json["token"]).status == 200
