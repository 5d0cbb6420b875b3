"""The gateway behaves as an HTTP API does: routes, events, CORS, limits, and failing functions."""

import asyncio
import base64
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.aws.emulator import LocalStack
from tests.aws.emulator.events import Response
from tests.aws.emulator.gateway import MAX_BODY_BYTES
from tests.aws.emulator.server import GatewayApp
from tests.helpers.stack.toy_stack import deploy

ECHO = """
    import json

    def handler(event, context):
        seen = {
            "event": event,
            "function": context.function_name,
            "request": context.aws_request_id,
            "left": context.get_remaining_time_in_millis(),
        }
        return {"statusCode": 200, "headers": {"content-type": "application/json"}, "body": json.dumps(seen)}
"""

SIZE = """
    def handler(event, context):
        return len(event["body"])
"""

ANSWERS = """
    import base64, pathlib, time
    def handler(event, context):
        kind = event["pathParameters"]["kind"]
        if kind == "crash":
            raise RuntimeError("a secret of the function")
        if kind == "unjson":
            return {"statusCode": 200, "body": {1, 2}}
        if kind == "slow":
            released = pathlib.Path(event["headers"]["x-release"])
            for _ in range(6_000):  # a minute
                if released.exists():
                    break
                time.sleep(0.01)
            return "late"
        return {
            "inferred": {"a": 1},
            "text": "just text",
            "null": None,
            "badstatus": {"statusCode": "fine"},
            "badbody": {"statusCode": 200, "body": {"not": "text"}},
            "badbase64": {"statusCode": 200, "body": "%%%", "isBase64Encoded": True},
            "badcookies": {"statusCode": 200, "cookies": "a=1"},
            "badheader": {"statusCode": 200, "headers": {"x": ["1", "2"]}},
            "large": {"statusCode": 200, "body": "x" * (7 * 1024 * 1024)},
            "binary": {"statusCode": 200, "headers": {"Content-Type": "image/jpeg"}, "isBase64Encoded": True,
                       "body": base64.b64encode(bytes(range(256))).decode()},
            "cookies": {"statusCode": 200, "cookies": ["a=1; Secure", "b=2"], "body": "ok"},
            "cors": {"statusCode": 200, "headers": {"Access-Control-Allow-Origin": "https://evil.example",
                     "access-control-allow-credentials": "true"}, "body": "ok"},
            "typed": {"statusCode": "201", "headers": {"x-number": 3, "x-flag": True, "Connection": "close"}},
            "empty": {"statusCode": 204},
            "redirect": {"statusCode": 307, "headers": {"location": "/elsewhere"}},
        }[kind]
"""


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LocalStack]:
    place = tmp_path_factory.mktemp("gateway")
    template = deploy(
        place,
        {
            "Echo": (
                ECHO,
                (
                    "GET /v1/echo",
                    "POST /v1/echo",
                    "ANY /v1/any",
                    "GET /v1/things/{id}",
                    "ANY /v1/things/{id}",
                ),
            ),
            "Literal": (ECHO, ("GET /v1/things/latest", "GET /v1/files/{path+}")),
            "Size": (SIZE, ("POST /v1/size",)),
            "Answers": (ANSWERS, ("GET /v1/answers/{kind}",)),
            "Broken": ("import no_such_module_anywhere", ("GET /v1/broken",)),
        },
    )
    with LocalStack(template=template) as running:
        yield running


def echoed(response: Response) -> Any:
    assert response.status == 200, response
    return response.json()["event"]


# ---------------------------------------------------------------- routes


@pytest.mark.parametrize(
    ("method", "path", "function", "key", "parameters"),
    [
        ("GET", "/v1/echo", "Echo", "GET /v1/echo", None),
        ("POST", "/v1/any", "Echo", "ANY /v1/any", None),
        ("GET", "/v1/things/7", "Echo", "GET /v1/things/{id}", {"id": "7"}),
        ("PATCH", "/v1/things/7", "Echo", "ANY /v1/things/{id}", {"id": "7"}),
        ("GET", "/v1/things/latest", "Literal", "GET /v1/things/latest", None),
        ("POST", "/v1/things/latest", "Echo", "ANY /v1/things/{id}", {"id": "latest"}),
        ("GET", "/v1/things/a%20b%C3%BC", "Echo", "GET /v1/things/{id}", {"id": "a bü"}),
        ("GET", "/v1/files/a/b/c", "Literal", "GET /v1/files/{path+}", {"path": "a/b/c"}),
    ],
)
def test_the_most_specific_route_answers(
    stack: LocalStack, method: str, path: str, function: str, key: str, parameters: dict[str, str] | None
) -> None:
    response = stack.request(method, path)
    event = echoed(response)
    assert response.json()["function"] == function
    assert event["routeKey"] == event["requestContext"]["routeKey"] == key
    assert event.get("pathParameters") == parameters


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", "/v1/absent"),
        ("PUT", "/v1/echo"),
        ("GET", "/v1/things/"),
        ("GET", "/v1/things/7/more"),
        ("GET", "/v1/echo/"),
    ],
)
def test_unknown_route_is_404(stack: LocalStack, method: str, path: str) -> None:
    response = stack.request(method, path)
    assert (response.status, response.body) == (404, b'{"message":"Not Found"}')
    assert response.headers["content-type"] == "application/json"


# ---------------------------------------------------------------- what a function is handed


def test_a_function_gets_event_and_context(stack: LocalStack) -> None:
    response = stack.request(
        "POST",
        "/v1/echo",
        headers={"Content-Type": "application/json", "Authorization": "Bearer x", "Cookie": "a=1; b=2"},
        query="camera=Logi%20C920&tag=1&tag=2",
        body=b'{"n":1}',
    )
    event = echoed(response)
    assert event["body"] == '{"n":1}'
    assert event["rawQueryString"] == "camera=Logi%20C920&tag=1&tag=2"
    assert event["queryStringParameters"] == {"camera": "Logi C920", "tag": "1,2"}
    assert event["cookies"] == ["a=1", "b=2"]
    assert "cookie" not in event["headers"]
    assert event["headers"]["authorization"] == "Bearer x"
    assert event["requestContext"]["requestId"] == response.json()["request"]
    assert 9000 < response.json()["left"] <= 10_000


def test_binary_bodies_are_base64(stack: LocalStack) -> None:
    image = bytes(range(256))
    event = echoed(stack.request("POST", "/v1/echo", headers={"content-type": "image/png"}, body=image))
    assert event["isBase64Encoded"] is True
    assert base64.b64decode(event["body"]) == image
    not_utf8 = echoed(
        stack.request("POST", "/v1/echo", headers={"content-type": "application/json"}, body=b'"\xff"')
    )
    assert base64.b64decode(not_utf8["body"]) == b'"\xff"'


# ---------------------------------------------------------------- what becomes of an answer


@pytest.mark.parametrize(
    ("kind", "status", "content_type", "body"),
    [
        ("inferred", 200, "application/json", b'{"a": 1}'),
        ("text", 200, "application/json", b"just text"),
        ("null", 200, "application/json", b"null"),
        ("binary", 200, "image/jpeg", bytes(range(256))),
        ("empty", 204, "text/plain; charset=utf-8", b""),
    ],
)
def test_answers_become_responses(
    stack: LocalStack, kind: str, status: int, content_type: str, body: bytes
) -> None:
    response = stack.request("GET", f"/v1/answers/{kind}")
    assert (response.status, response.headers["content-type"], response.body) == (status, content_type, body)


def test_headers_and_cookies_of_an_answer(stack: LocalStack) -> None:
    typed = stack.request("GET", "/v1/answers/typed")
    assert (typed.status, typed.headers["x-number"], typed.headers["x-flag"]) == (201, "3", "true")
    assert "connection" not in typed.headers
    assert stack.request("GET", "/v1/answers/cookies").cookies == ("a=1; Secure", "b=2")
    assert stack.request("GET", "/v1/answers/redirect").headers["location"] == "/elsewhere"


@pytest.mark.parametrize(
    "path",
    [
        *(f"/v1/answers/{kind}" for kind in ("crash", "unjson", "badstatus", "badbody", "badbase64")),
        *(f"/v1/answers/{kind}" for kind in ("badcookies", "badheader", "large")),
        "/v1/broken",
    ],
)
def test_malformed_function_response_is_a_bare_500(
    stack: LocalStack, path: str, caplog: pytest.LogCaptureFixture
) -> None:
    response = stack.request("GET", path)
    assert (response.status, response.body) == (500, b'{"message":"Internal Server Error"}')
    assert caplog.records, "the operator is told why"


def test_the_traceback_is_logged(stack: LocalStack, caplog: pytest.LogCaptureFixture) -> None:
    stack.request("GET", "/v1/answers/crash")
    assert "a secret of the function" in caplog.text
    assert "Traceback" in caplog.text


# ---------------------------------------------------------------- CORS

PREFLIGHT = {"access-control-request-method": "POST", "access-control-request-headers": "authorization"}


@pytest.mark.parametrize("path", ["/v1/echo", "/v1/nowhere"])
def test_preflight_that_no_route_matches_is_answered_by_the_gateway(stack: LocalStack, path: str) -> None:
    response = stack.request("OPTIONS", path, headers={"origin": "https://page.example", **PREFLIGHT})
    assert (response.status, response.body) == (204, b"")
    assert response.headers == {
        "access-control-allow-origin": "https://page.example",
        "access-control-allow-methods": "GET,POST",
        "access-control-allow-headers": "authorization,content-type",
        "access-control-expose-headers": "location",
        "access-control-max-age": "600",
        "vary": "origin",
    }


def test_preflight_that_an_any_route_matches_goes_to_its_function(stack: LocalStack) -> None:
    """As users of HTTP APIs report, against what the guide seems to say."""
    event = echoed(
        stack.request("OPTIONS", "/v1/any", headers={"origin": "https://page.example", **PREFLIGHT})
    )
    assert (event["routeKey"], event["requestContext"]["http"]["method"]) == ("ANY /v1/any", "OPTIONS")


def test_a_preflight_of_another_origin_gets_no_permission(stack: LocalStack) -> None:
    response = stack.request("OPTIONS", "/v1/echo", headers={"origin": "https://evil.example", **PREFLIGHT})
    assert (response.status, dict(response.headers)) == (204, {})


def test_the_gateways_cors_headers_replace_the_functions(stack: LocalStack) -> None:
    response = stack.request("GET", "/v1/answers/cors", headers={"origin": "https://other.example"})
    assert response.headers["access-control-allow-origin"] == "https://other.example"
    assert "access-control-allow-credentials" not in response.headers
    without = stack.request("GET", "/v1/answers/cors")
    assert not [name for name in without.headers if name.startswith("access-control-")]


def test_failures_can_be_read_across_origins(stack: LocalStack) -> None:
    for path in ("/v1/absent", "/v1/answers/crash"):
        response = stack.request("GET", path, headers={"origin": "https://page.example"})
        assert response.headers["access-control-allow-origin"] == "https://page.example"


# ---------------------------------------------------------------- limits


def test_a_body_of_more_than_six_megabytes_is_refused(stack: LocalStack) -> None:
    text = {"content-type": "text/plain"}
    assert (
        stack.request("POST", "/v1/size", headers=text, body=b"x" * MAX_BODY_BYTES).json() == MAX_BODY_BYTES
    )
    response = stack.request("POST", "/v1/size", headers=text, body=b"x" * (MAX_BODY_BYTES + 1))
    assert (response.status, response.body) == (413, b'{"message":"Request Entity Too Large"}')


def test_endless_body_is_refused(stack: LocalStack) -> None:
    def chunks() -> Iterator[bytes]:
        for _ in range(200):
            yield b"x" * 100_000

    with stack.serve() as url:
        origin = {"origin": "https://page.example"}
        response = httpx.post(f"{url}/v1/echo", content=chunks(), headers=origin, timeout=60)
    assert (response.status_code, response.json()) == (413, {"message": "Request Entity Too Large"})
    assert response.headers["access-control-allow-origin"] in ("*", "https://page.example")


def test_the_gateway_gives_up_on_a_slow_function(stack: LocalStack, tmp_path: Path) -> None:
    workers, released = ThreadPoolExecutor(1), tmp_path / "released"
    app = GatewayApp(stack.gateway, workers, tmp_path, {}, timeout=0.05)

    async def ask() -> httpx.Response:
        transport = httpx.ASGITransport(app=app)
        async with httpx.AsyncClient(transport=transport, base_url="http://localhost") as client:
            headers = {"origin": "https://page.example", "x-release": str(released)}
            return await client.get("/v1/answers/slow", headers=headers)

    response = asyncio.run(ask())
    released.touch()
    assert (response.status_code, response.json()) == (503, {"message": "Service Unavailable"})
    assert "access-control-allow-origin" in response.headers  # or the page could not read it
    workers.shutdown()
