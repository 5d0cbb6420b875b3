"""No secret of a token in any log, whatever its endpoints are asked and however that ends."""

import logging
from json import loads

import pytest

from calibdb.store.sqlite import SqliteTable
from infra.server.server import Server
from tests.helpers.clock import Clock
from tests.helpers.service.in_process import request
from tests.helpers.service.strangers import SITE


def test_no_endpoint_of_tokens_writes_a_secret_into_a_log(
    stack: Server,
    clock: Clock,  # noqa: ARG001
    site: dict[str, str],
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    capfd: pytest.CaptureFixture[str],
) -> None:
    caplog.set_level(logging.DEBUG)
    plain = {"content-type": "application/json"}

    def ask(
        method: str, path: str, credential: str = "", body: bytes = b"", query: str = ""
    ) -> tuple[int, bytes]:
        headers = {**plain, "authorization": f"Bearer {credential}"} if credential else plain
        answer = request(stack, method, path, headers, query, body, client="198.18.200.1")
        return answer.status, answer.body

    made = loads(ask("POST", "/v1/tokens", body=f'{{"origins": ["http://localhost", "{SITE}"]}}'.encode())[1])
    token, managing = made["token"], made["management_token"]
    site["example.org"] = f"calibdb-site-verification={made['id']}"
    rotated = loads(ask("POST", "/v1/tokens/self/rotate", managing)[1])["token"]
    wrong = managing[:-1] + ("0" if managing[-1] != "0" else "1")
    calls = [
        ("GET", "/v1/tokens/self", b""),
        ("PATCH", "/v1/tokens/self", f'{{"name": "{managing}", "odd": "{token}"}}'.encode()),
        ("POST", "/v1/tokens/self/verify", b""),
        ("POST", "/v1/tokens/self/rotate", f'{{"grace_s": "{managing}"}}'.encode()),
        ("POST", "/v1/tokens/self", b""),
        ("GET", f"/v1/tokens/{managing}", b""),
    ]
    secrets = (managing, wrong, token)
    statuses = {ask(method, path, secret, body)[0] for secret in secrets for method, path, body in calls}
    assert statuses >= {200, 403, 404, 405, 422}
    for secret in (token, rotated, managing):
        ask("GET", "/v1/usage", secret)
        ask("POST", "/v1/lookup", secret, b"{}")
        ask("GET", "/v1/lookup", query=f"key={secret}")
    # An error that nobody foresaw, which is logged with its trace.
    monkeypatch.setattr(SqliteTable, "get", lambda *_: 1 / 0)
    assert {ask(method, path, managing, body)[0] for method, path, body in calls} >= {500}
    monkeypatch.undo()
    assert ask("DELETE", "/v1/tokens/self", managing)[0] == 204
    written = caplog.text + "".join(capfd.readouterr())
    assert "ZeroDivisionError" in written, "logs are captured here"
    for secret in (token, rotated, managing, wrong):
        assert secret not in written
        assert secret.rpartition("_")[2] not in written
