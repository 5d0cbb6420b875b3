"""Credentials: missing ones are 401, wrong ones 403, on every call."""

import re
import time
from collections.abc import Callable
from typing import Any

import pytest

from calibdb.access.tokens import ApiToken, SessionIds, Ticket, secret_hash
from calibdb.store import Store
from infra.server.server import Server
from infra.web_build.openapi import OPERATIONS
from tests.helpers.service.client import CAMERA, TOKEN, Client
from tests.helpers.service.intercepted import intercepted_service


def calls(*credentials: str) -> list[tuple[str, str]]:
    """Method and path of every call with at least the first of these credentials, and no others."""
    return [
        (operation.method.upper(), re.sub(r"{\w+}", "0", operation.path))
        for operation in OPERATIONS
        if credentials[0] in operation.credentials and set(credentials).issuperset(operation.credentials)
    ]


BY_TOKEN = calls("apiToken", "apiTokenInQuery", "apiTokenInOldQuery")
BY_SESSION = calls("sessionId")


@pytest.mark.parametrize(("method", "path"), BY_TOKEN + BY_SESSION)
def test_missing(client: Client, method: str, path: str) -> None:
    for headers in ({}, {"authorization": "Basic Y2RiOmNkYg=="}, {"authorization": "Bearer "}):
        answer = client.call(method, path, token="", headers=headers)
        assert answer.status == 401
        assert answer.headers["www-authenticate"].startswith("Bearer")


@pytest.mark.parametrize(("method", "path"), BY_TOKEN)
def test_wrong_token(running: Client, method: str, path: str) -> None:
    for token in ("cdb_dev_wrong", "cdb_nobody_local", "cdb_dev", "cdb_dev_local_", "é", running.session_id):
        assert running.call(method, path, token=token).status == 403


@pytest.mark.parametrize(("method", "path"), BY_TOKEN)
def test_nothing_tells_an_unknown_token_from_a_wrong_secret(
    stack: Server, store: Store, client: Client, method: str, path: str
) -> None:
    """Neither the answer nor what is asked of storage, by which its time is spent."""
    token_id = f"rare{len(path)}{method.lower()}"
    store.tokens.create(ApiToken(token_id, secret_hash("s3cret")))
    met = []
    for token in ("cdb_nobody_s3creT", f"cdb_{token_id}_s3creT"):
        asked = []

        def record(operation: str, call: Callable[[], Any], asked: list[str] = asked) -> Any:
            asked.append(operation)
            return call()

        with intercepted_service(stack.storage, record):
            answer = client.call(method, path, token=token)
        met.append((answer.status, answer.body, sorted(answer.headers), asked))
    assert met[0] == met[1]
    assert met[0][0] == 403
    assert met[0][-1] == ["GetItem"]


@pytest.mark.parametrize(("method", "path"), BY_SESSION)
def test_wrong_session_id(client: Client, method: str, path: str) -> None:
    opened = client.call("POST", "/v1/auth").json["session_id"]
    forged = opened[:-2] + ("AA" if opened[-2:] != "AA" else "BB")
    for session_id in (TOKEN, forged, opened[1:], "x" * 5000, "."):
        assert client.call(method, path, token=session_id).status == 403


def test_an_expired_session_id_says_so(stack: Server, client: Client) -> None:
    secrets = stack.environment["SESSION_SECRETS"].split(",")
    for clock, problem in (
        (lambda: time.time() - 7200, (403, "session-expired")),
        (time.time, (404, "no-session")),
    ):
        session_id, _ = SessionIds(secrets, clock).issue(Ticket("0" * 24, "dev"))
        assert client.call("GET", "/v1/session", token=session_id).problem == problem


def test_get_lookup_takes_the_token_in_its_query(client: Client) -> None:
    for name in ("key", "api_key"):
        for token, status in ((TOKEN, 307), ("cdb_dev_x", 403)):
            query = f"camera=Test&platform=X11&img_size=1280x720&{name}={token}"
            assert client.call("GET", "/v1/lookup", token="", query=query).status == status


def test_a_page_of_another_origin_is_refused(store: Store, client: Client) -> None:
    store.tokens.create(ApiToken("page", secret_hash("s3cret"), origins=("https://shop.example",)))
    ours, other = {"origin": "https://shop.example"}, {"origin": "https://thief.example"}
    for method, path in BY_TOKEN:
        refused = client.call(method, path, token="cdb_page_s3cret", headers=other)
        assert refused.status == 403
        admitted = client.call(method, path, token="cdb_page_s3cret", headers=ours)
        assert admitted.status != 403

    opened = client.call("POST", "/v1/auth", token="cdb_page_s3cret", headers=ours).json["session_id"]
    assert client.call("POST", "/v1/session", CAMERA, token=opened, headers=ours).status == 201
    for method, path in BY_SESSION:
        assert client.call(method, path, token=opened, headers=other).status == 403


def test_pages_of_the_site_itself_may_use_any_token(stack: Server, store: Store, client: Client) -> None:
    store.tokens.create(ApiToken("tried", secret_hash("s3cret"), origins=("https://shop.example",)))
    for origin, status in ((stack.url, 201), (f"{stack.url}.thief.example", 403), (f"{stack.url}1", 403)):
        answer = client.call("POST", "/v1/auth", token="cdb_tried_s3cret", headers={"origin": origin})
        assert answer.status == status, origin


def test_the_index_holds_no_secret(store: Store) -> None:
    token = store.tokens.get("dev")
    assert token.secret_sha256 == secret_hash("local")
    assert "'local'" not in repr(token)
