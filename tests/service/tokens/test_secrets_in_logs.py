"""No secret of a token in any log, whatever its endpoints are asked and however that ends."""

import logging

import pytest

from calibdb.store.sqlite import SqliteTable
from tests.helpers.service.client import Client
from tests.helpers.service.strangers import SITE, make, manage, rotate


def test_no_endpoint_of_tokens_writes_a_secret_into_a_log(
    client: Client,
    site: dict[str, str],
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    capfd: pytest.CaptureFixture[str],
) -> None:
    caplog.set_level(logging.DEBUG)
    made = make(client, "http://localhost", SITE)
    token, managing = made["token"], made["management_token"]
    site["example.org"] = f"calibdb-site-verification={made['id']}"
    rotated = rotate(client, made)["token"]
    wrong = managing[:-1] + ("0" if managing[-1] != "0" else "1")
    calls = [
        ("GET", "/v1/tokens/self", None),
        ("PATCH", "/v1/tokens/self", {"name": managing, "odd": token}),
        ("POST", "/v1/tokens/self/verify", None),
        ("POST", "/v1/tokens/self/rotate", {"grace_s": managing}),
        ("POST", "/v1/tokens/self", None),
        ("GET", f"/v1/tokens/{managing}", None),
    ]

    def ask(secret: str) -> set[int]:
        return {client.call(method, path, body, token=secret).status for method, path, body in calls}

    assert ask(managing) | ask(wrong) | ask(token) >= {200, 403, 404, 405, 422}
    for secret in (token, rotated, managing):
        client.call("GET", "/v1/usage", token=secret)
        client.call("POST", "/v1/lookup", {}, token=secret)
        client.call("GET", "/v1/lookup", token="", query=f"key={secret}")
    # An error that nobody foresaw, which is logged with its trace.
    monkeypatch.setattr(SqliteTable, "get", lambda *_: 1 / 0)
    assert 500 in ask(managing)
    monkeypatch.undo()
    assert manage(client, "DELETE", made).status == 204
    written = caplog.text + "".join(capfd.readouterr())
    assert "ZeroDivisionError" in written, "logs are captured here"
    for secret in (token, rotated, managing, wrong):
        assert secret not in written
        assert secret.rpartition("_")[2] not in written
