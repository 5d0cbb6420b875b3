"""HTTP requests as payload format 2.0 events, and handlers' answers as HTTP responses.

Source: Amazon API Gateway developer guide, "Create AWS Lambda proxy integrations for HTTP APIs". Members that
no function reads are left out.
"""

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote

from tests.helpers.service.in_process import Response

_NOT_PASSED = {"connection", "transfer-encoding", "cookie"}
"""Headers of the connection; cookies are a member of the event, which no function reads."""


@dataclass(frozen=True)
class Request:
    """An HTTP request as it arrived."""

    method: str
    path: str  # percent-encoded
    query: str = ""  # without the question mark, percent-encoded
    headers: tuple[tuple[str, str], ...] = ()
    body: bytes = b""
    source_ip: str = "127.0.0.1"

    def header(self, name: str) -> str | None:
        """Return the first header of that name (lower case)."""
        return next((value for key, value in self.headers if key.lower() == name), None)


def message(status: int, text: str) -> Response:
    """Return one of API Gateway's own answers: `{"message": …}`."""
    content = json.dumps({"message": text}, separators=(",", ":"))
    return Response(status, {"content-type": "application/json"}, content.encode())


def to_event(request: Request, route_key: str) -> dict[str, Any]:
    """Make the event that a function behind an HTTP API gets for this request.

    `rawPath` is decoded, as HTTP APIs deliver it (REST APIs and function URLs do not); `rawQueryString` is
    not. An absent body is absent, not empty.
    """
    headers: dict[str, str] = {}
    for name, value in request.headers:
        name = name.lower()
        if name in _NOT_PASSED:
            continue
        headers[name] = f"{headers[name]},{value}" if name in headers else value
    path = unquote(request.path)
    body, is_base64 = _body(request.body)
    event = {
        "version": "2.0",
        "routeKey": route_key,
        "rawPath": path,
        "rawQueryString": request.query,
        "headers": headers
        | {
            "content-length": str(len(request.body)),
            "x-forwarded-for": ", ".join(filter(None, (headers.get("x-forwarded-for"), request.source_ip))),
            "x-forwarded-port": headers.get("host", "").partition(":")[2] or "80",
            "x-forwarded-proto": "http",
        },
        "requestContext": {
            "http": {"method": request.method, "path": path, "sourceIp": request.source_ip},
            "routeKey": route_key,
        },
        "isBase64Encoded": is_base64,
    }
    return {**event, "body": body} if body else event


def to_response(answer: Mapping[str, Any]) -> Response:
    """Convert a handler's result to an HTTP response."""
    headers = {name.lower(): str(value) for name, value in answer["headers"].items()}
    headers.pop("content-length", None)
    body = answer.get("body") or ""
    content = base64.b64decode(body) if answer.get("isBase64Encoded") else body.encode()
    return Response(answer["statusCode"], headers, content)


def _body(body: bytes) -> tuple[str, bool]:
    try:
        return body.decode("utf-8"), False
    except UnicodeDecodeError:  # JSON could not carry it as text
        return base64.b64encode(body).decode("ascii"), True
