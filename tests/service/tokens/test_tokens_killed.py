"""A kill at any moment: tokens are as they were acknowledged, and what was cut off can be asked again."""

import functools
import json
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx
import pytest
from botocore.awsrequest import AWSPreparedRequest

from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store
from infra.local import LocalStack
from infra.local.intercept import Service as Storage
from infra.local.intercept import wrapping
from infra.local.storage import Answer as Stored
from tests.helpers.service.client import CAMERA, EDGE, Answer, Client
from tests.helpers.stack.processes import LocalProcess

SITE = "https://example.org"
WRITES = {"PutItem", "UpdateItem", "DeleteItem", "PutObject"}


class KilledError(BaseException):
    """The process ended here."""


@dataclass
class Process:
    """Process that is killed, and the number of its writes until then."""

    written: int = 0
    killed: bool = False


@contextmanager
def killed_at(number: int) -> Iterator[Process]:
    """Let the process end before its write of this number: nothing is written or read from there on."""
    process = Process()

    def around(_: str, service: Storage) -> Storage:
        def handle(operation: str, request: AWSPreparedRequest) -> Stored:
            process.killed = process.killed or (operation in WRITES and process.written == number)
            if process.killed:
                raise KilledError
            process.written += operation in WRITES
            return service(operation, request)

        return handle

    with wrapping(around):
        yield process


@pytest.fixture(scope="module")
def stack() -> Iterator[LocalStack]:
    @functools.cache
    def make(settings: Settings) -> Service:
        return Service.build(settings, Store.of(settings), token_ttl_s=0)

    with LocalStack(environment={"EDGE_SECRETS": EDGE}) as stack, Service.override(make):
        yield stack


@dataclass
class Owner:
    """Somebody with a token of their own."""

    client: Client
    made: Any = field(init=False)

    def __post_init__(self) -> None:
        body = {"origins": ["http://localhost", SITE]}
        self.made = self.client.call("POST", "/v1/tokens", body, token="").json

    def manage(self, method: str, action: str = "", body: object = None) -> Answer:
        return self.client.call(method, f"/v1/tokens/self{action}", body, token=self.made["management_token"])

    def send(self, method: str, action: str, body: object) -> int:
        """Send a request that nobody may live to answer; return its status."""
        headers = {"authorization": f"Bearer {self.made['management_token']}"}
        content = b"" if body is None else json.dumps(body).encode()
        return self.client.stack.request(method, f"/v1/tokens/self{action}", headers, body=content).status

    def lookup(self, token: str, origin: str | None = None) -> int:
        headers = {} if origin is None else {"origin": origin}
        body = {**CAMERA, "miss": "ok"}
        return self.client.call("POST", "/v1/lookup", body, token=token, headers=headers).status


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
    stack: LocalStack,
    monkeypatch: pytest.MonkeyPatch,
    method: str,
    action: str,
    body: object,
    holds: Callable[[Owner, Answer], None],
) -> None:
    number = 0
    while True:
        owner = Owner(Client(stack, address=f"198.18.{hash(action + method) % 200}.{number}"))
        line = f"calibdb-site-verification={owner.made['id']}"
        monkeypatch.setattr("calibdb.proof.fetch.read_proof", lambda _, line=line: line)
        with killed_at(number) as process:
            status = owner.send(method, action, body)
        assert status == 500 if process.killed else status < 300
        if action == "/rotate":
            assert owner.lookup(owner.made["token"]) == 200
        holds(owner, owner.manage(method, action, body))
        if not process.killed:
            break
        number += 1
    assert number >= 3  # counted, stored, indexed


def test_killed_while_a_token_is_made_leaves_none_half_made(stack: LocalStack) -> None:
    for number in range(4):
        client = Client(stack, address=f"198.19.0.{number}")
        edge = {"x-calibdb-edge": EDGE, "x-forwarded-for": client.address}
        with killed_at(number) as process:
            stack.request("POST", "/v1/tokens", edge, body=b'{"origins": ["http://localhost"]}')
        assert process.killed
        answer = client.call("POST", "/v1/tokens", {"origins": ["http://localhost"]}, token="")
        assert answer.status == 201
        assert client.call("GET", "/v1/usage", token=answer.json["token"]).status == 200


def rotate_until_cut_off(url: str, acknowledged: dict[str, Any], *, used: bool) -> None:
    with httpx.Client(base_url=url, timeout=60) as client:
        made = client.post("/v1/tokens", json={"origins": ["http://localhost"]}).raise_for_status().json()
        acknowledged |= {"token": made["token"], "managing": made["management_token"], "secrets": 1}
        managing = {"authorization": f"Bearer {made['management_token']}"}
        acknowledged["expires"] = made["expires"]
        if used:
            headers = {"authorization": f"Bearer {made['token']}"}
            client.get("/v1/usage", headers=headers).raise_for_status()
            acknowledged["expires"] = None
        try:
            for number in range(50):
                rotated = client.post("/v1/tokens/self/rotate", headers=managing, json={"grace_s": 600})
                acknowledged["token"] = rotated.raise_for_status().json()["token"]
                acknowledged["secrets"] += 1
                named = client.patch("/v1/tokens/self", headers=managing, json={"name": f"{number}"})
                acknowledged["name"] = named.raise_for_status().json()["name"]
        except httpx.TransportError:
            acknowledged["cut off"] = True


def test_acknowledged_secrets_open_after_a_kill(tmp_path: Path) -> None:
    data_dir = tmp_path / "data"
    tokens: list[dict[str, Any]] = [{} for _ in range(4)]
    with LocalProcess(data_dir) as server, ThreadPoolExecutor(4) as pool:
        workers = [
            pool.submit(rotate_until_cut_off, server.url, token, used=n % 2 == 0)
            for n, token in enumerate(tokens)
        ]
        while sum(token.get("secrets", 0) for token in tokens) < 40:
            time.sleep(0.005)
            for worker in workers:
                assert not worker.done(), worker.result()
        server.kill()
        for worker in workers:
            worker.result(60)
    assert all(token["cut off"] for token in tokens)
    with LocalProcess(data_dir) as server, httpx.Client(base_url=server.url, timeout=60) as client:
        for token in tokens:
            managing = {"authorization": f"Bearer {token['managing']}"}
            facts = client.get("/v1/tokens/self", headers=managing).raise_for_status().json()
            assert facts["expires"] == token["expires"], "of an unused token alone"
            assert sum(day["lookups"] for day in facts["use"]["days"]) == (token["expires"] is None)
            opened = client.get("/v1/usage", headers={"authorization": f"Bearer {token['token']}"})
            assert opened.status_code == 200, opened.text
            assert int(facts["name"]) in {int(token["name"]), int(token["name"]) + 1}
            assert client.delete("/v1/tokens/self", headers=managing).status_code == 204
        refused = [client.post("/v1/tokens", json={"origins": ["http://localhost"]}) for _ in range(2)]
        assert [answer.status_code for answer in refused] == [201, 429]  # the day's five were counted
