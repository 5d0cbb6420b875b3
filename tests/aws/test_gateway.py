"""The emulated gateway behaves as an HTTP API does: routes, CORS, limits, and failing functions."""

from collections.abc import Iterator
from typing import Any

import pytest

from tests.aws.emulator import LocalStack
from tests.aws.emulator.events import Response
from tests.aws.emulator.gateway import MAX_BODY_BYTES
from tests.helpers.stack.toy_stack import deploy

ECHO = """
    import json

    def handler(event, context):
        seen = {
            "event": event,
            "function": context.function_name,
        }
        return {"statusCode": 200, "headers": {"content-type": "application/json"}, "body": json.dumps(seen)}
"""

CRASH = """
    def handler(event, context):
        raise RuntimeError("a secret of the function")
"""
OWN_CORS = """
    def handler(event, context):
        headers = {"Access-Control-Allow-Origin": "https://evil.example"}
        return {"statusCode": 200, "headers": headers, "body": "ok"}
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
            "Literal": (ECHO, ("GET /v1/things/latest",)),
            "Crash": (CRASH, ("GET /v1/crash",)),
            "OwnCors": (OWN_CORS, ("GET /v1/cors",)),
            "Broken": ("import no_such_module_anywhere", ("GET /v1/broken",)),
        },
    )
    with LocalStack(template=template) as running:
        yield running


def echoed(response: Response) -> Any:
    assert response.status == 200, response
    return response.json()["event"]


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
        ("GET", "/v1/things/7/more"),
    ],
)
def test_unknown_route_is_404(stack: LocalStack, method: str, path: str) -> None:
    response = stack.request(method, path)
    assert (response.status, response.body) == (404, b'{"message":"Not Found"}')
    assert response.headers["content-type"] == "application/json"


@pytest.mark.parametrize("path", ["/v1/crash", "/v1/broken"])
def test_failure_is_a_bare_500(stack: LocalStack, path: str, caplog: pytest.LogCaptureFixture) -> None:
    response = stack.request("GET", path, headers={"origin": "https://page.example"})
    assert (response.status, response.body) == (500, b'{"message":"Internal Server Error"}')
    assert response.headers["access-control-allow-origin"] == "https://page.example"
    assert "Traceback" in caplog.text, "the log states the cause"


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
    response = stack.request("GET", "/v1/cors", headers={"origin": "https://other.example"})
    assert response.headers["access-control-allow-origin"] == "https://other.example"
    without = stack.request("GET", "/v1/cors")
    assert not [name for name in without.headers if name.startswith("access-control-")]


def test_a_body_of_more_than_six_megabytes_is_refused(stack: LocalStack) -> None:
    echoed(stack.request("POST", "/v1/echo", body=b"x" * 100_000))
    response = stack.request("POST", "/v1/echo", body=b"x" * (MAX_BODY_BYTES + 1))
    assert (response.status, response.body) == (413, b'{"message":"Request Entity Too Large"}')
