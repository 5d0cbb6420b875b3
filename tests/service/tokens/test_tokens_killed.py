"""A kill at any moment: what was cut off can be asked again."""

import zlib
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from infra.server.server import Server
from tests.helpers.service.client import Answer, Client
from tests.helpers.service.intercepted import crash_after
from tests.helpers.service.stores import override_service
from tests.helpers.service.strangers import SITE, ask, make, manage


@pytest.fixture(scope="module")
def stack() -> Iterator[Server]:
    with Server() as stack, override_service(token_ttl_s=0):
        yield stack


def rotated(client: Client, made: Any, answer: Answer) -> None:
    assert ask(client, made["token"]).status == 200  # that is in use somewhere
    assert ask(client, answer.json["token"]).status == 200


def verified(client: Client, made: Any, answer: Answer) -> None:
    assert {origin["state"] for origin in answer.json["origins"]} == {"verified"}
    assert answer.json["plan"] == "free"
    assert ask(client, made["token"], SITE).status == 200


def changed(client: Client, made: Any, answer: Answer) -> None:
    assert [origin["origin"] for origin in answer.json["origins"]] == ["http://127.0.0.1"]
    assert ask(client, made["token"], "http://localhost").status == 403
    assert ask(client, made["token"], "http://127.0.0.1").status == 200


def revoked(client: Client, made: Any, answer: Answer) -> None:
    assert answer.status == 204
    assert ask(client, made["token"]).status == 403


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
    holds: Callable[[Client, Any, Answer], None],
) -> None:
    for writes in range(10):
        client = Client(stack, address=f"198.18.{zlib.crc32((action + method).encode()) % 200}.{writes}")
        made = make(client, "http://localhost", SITE)
        line = f"calibdb-site-verification={made['id']}"
        monkeypatch.setattr("calibdb.proof.read_proof", lambda _, line=line: line)
        with crash_after(stack.storage, writes, token_ttl_s=0):
            first = manage(client, method, made, action, body)
        if action == "/rotate":
            assert ask(client, made["token"]).status == 200
        holds(client, made, manage(client, method, made, action, body))
        if first.status < 300:
            break
        assert first.status == 503
    assert 3 <= writes < 9  # counted, stored, indexed


def test_killed_while_a_token_is_made_leaves_none_half_made(stack: Server) -> None:
    for writes in range(4):
        client = Client(stack, address=f"198.19.0.{writes}")
        with crash_after(stack.storage, writes, token_ttl_s=0):
            assert client.call("POST", "/v1/tokens", {"origins": ["http://localhost"]}).status == 503
        made = make(client)
        assert client.call("GET", "/v1/usage", token=made["token"]).status == 200
