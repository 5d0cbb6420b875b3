"""HTTP by the smallest function there is: routes, errors, nothing of a trace, and the source address."""

import json
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from starlette.requests import Request
from starlette.responses import Response

from calibdb.errors import ConflictError, NotFoundError
from calibdb.http import application
from calibdb.http.call import Call
from calibdb.settings import Settings
from tests.unit.service.test_settings import ENVIRONMENT

pytestmark = pytest.mark.usefixtures("function_environment")
TYPES = ("image/jpeg", "image/png", "application/json")


def pick(call: application.Call) -> Response:
    return Response(call.negotiate_media_type(TYPES))


def conflict(_: application.Call) -> Response:
    raise ConflictError("Not now.", kind="busy", extensions={"who": "you"}, headers={"X-Why": "because"})


def crash(_: application.Call) -> Response:
    raise RuntimeError("the secret is 4711")


def blob(_: application.Call) -> Response:
    return Response(b"\xff\xd8\xff", media_type="image/jpeg")


HANDLER = application.handler(
    application.route("/pick", GET=pick),
    application.route("/conflict", POST=conflict, GET=pick),
    application.route("/crash", GET=crash),
    application.route("/blob", GET=blob),
)


HTTP = {"method": "GET", "sourceIp": "192.0.2.1"}
EVENT = {"version": "2.0", "rawQueryString": "", "isBase64Encoded": False}


def send(method: str, path: str, headers: dict[str, str] | None = None) -> dict[str, Any]:
    context = {"http": {**HTTP, "method": method, "path": path}}
    event = {"routeKey": f"{method} {path}", "rawPath": path, "requestContext": context}
    return HANDLER({**EVENT, **event, "headers": headers or {}}, None)


@pytest.mark.parametrize(
    ("accept", "chosen"),
    [
        ("", "image/jpeg"),
        ("IMAGE/PNG", "image/png"),
        ("image/*;q=0.2, application/json;q=0.3", "application/json"),
        ("image/jpeg;q=0, image/*", "image/png"),
        ("application/json; charset=utf-8", "application/json"),
        ("image/png;q=nonsense", "image/png"),
        (",;,", None),
        ("*/*;q=0", None),
    ],
)
def test_accept_header_selects_the_media_type(accept: str, chosen: str | None) -> None:
    answer = send("GET", "/pick", {"accept": accept})
    assert answer["statusCode"] == (200 if chosen else 406)
    if chosen:
        assert answer["body"] == chosen


def test_an_error_is_a_problem() -> None:
    answer = send("POST", "/conflict")
    assert answer["statusCode"] == 409
    assert answer["headers"]["content-type"] == "application/problem+json"
    assert answer["headers"]["x-why"] == "because"
    assert answer["isBase64Encoded"] is False
    assert json.loads(answer["body"]) == {
        "type": "https://calibdb.example/docs/problems/#busy",
        "title": "Conflict",
        "status": 409,
        "detail": "Not now.",
        "who": "you",
    }


@pytest.mark.parametrize("path", ["/nowhere", "/conflict/", "/{}"])
def test_no_such_path(path: str) -> None:
    answer = send("GET", path)
    problem = json.loads(answer["body"])
    assert (answer["statusCode"], problem["status"]) == (404, 404)
    other = NotFoundError("").problem()
    assert (problem["type"], problem["title"]) == (f"https://calibdb.example{other['type']}", other["title"])


def test_a_wrong_method_is_told_the_right_ones() -> None:
    answer = send("DELETE", "/conflict")
    problem = json.loads(answer["body"])
    assert (answer["statusCode"], problem["status"]) == (405, 405)
    assert set(answer["headers"]["allow"].split(", ")) == {"GET", "HEAD", "POST"}
    assert answer["headers"]["allow"] in problem["detail"]


def test_event_may_omit_empty_members() -> None:
    event = EVENT | {"rawPath": "/pick", "requestContext": {"http": {**HTTP, "path": "/pick"}}}
    for headers in ({}, {"headers": None}, {"headers": {"Accept": "IMAGE/PNG", "HOST": "a:b"}}):
        answer = HANDLER({**event, **headers}, None)
        assert (answer["statusCode"], answer["body"]) == (
            200,
            "image/png" if headers.get("headers") else TYPES[0],
        )


def test_unhandled_error_is_a_bare_500(caplog: pytest.LogCaptureFixture) -> None:
    answer = send("GET", "/crash")
    assert answer["statusCode"] == 500
    assert answer["headers"]["content-type"] == "application/problem+json"
    assert "4711" not in json.dumps(answer)
    assert "RuntimeError" not in json.dumps(answer)
    assert "4711" in caplog.text  # the operator reads it in the log


def test_pictures_leave_as_base64() -> None:
    answer = send("GET", "/blob")
    assert (answer["isBase64Encoded"], answer["body"]) == (True, "/9j/")


@pytest.mark.parametrize("path", ["/pick", "/nowhere"])
def test_preflight_is_allowed_on_every_path_without_settings(
    path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the function itself: an HTTP API may hand it preflights, which its `ANY` routes match."""
    for name in ENVIRONMENT:
        monkeypatch.delenv(name)
    answer = send(
        "OPTIONS", path, {"origin": "https://page.example", "access-control-request-method": "POST"}
    )
    assert answer["statusCode"] == 204
    headers = {name.lower(): value for name, value in answer["headers"].items()}
    assert headers["access-control-allow-origin"] == "*"
    assert {"GET", "POST", "PATCH", "DELETE"} <= set(headers["access-control-allow-methods"].split(","))
    assert {"authorization", "content-type"} <= set(headers["access-control-allow-headers"].split(","))
    assert not answer.get("body")


SECRET, NEXT = "e" * 32, "f" * 32
SETTINGS = Settings.from_environment({**ENVIRONMENT, "EDGE_SECRETS": f"{SECRET},{NEXT}"})


def address(forwarded: str, shown: str | None, settings: Settings = SETTINGS) -> str:
    headers = [(b"x-forwarded-for", forwarded.encode())]
    if shown is not None:
        headers.append((b"x-calibdb-edge", shown.encode("latin-1")))
    scope = {"type": "http", "headers": headers, "client": ("198.51.100.9", 0)}
    return Call(Request(scope), b"", SimpleNamespace(settings=settings)).address


@pytest.mark.parametrize("forwarded", ["192.0.2.7, 198.51.100.9", "203.0.113.1, 192.0.2.7, 198.51.100.9"])
@pytest.mark.parametrize("shown", [SECRET, NEXT])
def test_address_is_the_edges_not_a_forged_header(forwarded: str, shown: str) -> None:
    assert address(forwarded, shown) == "192.0.2.7"


@pytest.mark.parametrize("shown", [None, "", "e" * 31, "ü"])
def test_address_header_without_secret_is_ignored(shown: str | None) -> None:
    assert address("192.0.2.7, 198.51.100.9", shown) == "198.51.100.9"


def test_address_is_the_gateways_without_secrets_or_hops() -> None:
    assert address("192.0.2.7, 198.51.100.9", "", replace(SETTINGS, edge_secrets=())) == "198.51.100.9"
    assert address("198.51.100.9", SECRET) == "198.51.100.9"


def test_requests_with_an_unknown_secret_are_counted(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("AWS_LAMBDA_RUNTIME_API", "127.0.0.1:9001")
    address("192.0.2.7, 198.51.100.9", "g" * 32)
    assert '"UnknownEdges":1' in capsys.readouterr().out
    address("192.0.2.7, 198.51.100.9", None)  # the API's own address
    address("192.0.2.7, 198.51.100.9", SECRET)
    assert capsys.readouterr().out == ""
