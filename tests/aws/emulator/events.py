"""HTTP requests as payload format 2.0 events, and handlers' answers as HTTP responses.

Source: Amazon API Gateway developer guide, "Create AWS Lambda proxy integrations for HTTP APIs".
"""

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any
from urllib.parse import parse_qsl, unquote

from tests.aws.emulator.intrinsics import ACCOUNT
from tests.helpers.service.in_process import Response

API_ID = "local"

# What belongs to one connection and not to the request or response (RFC 9110, 7.6.1), and what the server
# sets.
_HOP_BY_HOP = frozenset(
    {"connection", "keep-alive", "proxy-connection", "te", "trailer", "transfer-encoding", "upgrade"}
)
_TEXT = ("text/", "application/json", "application/javascript", "application/xml", "application/graphql")


@dataclass(frozen=True)
class Request:
    """An HTTP request as it arrived."""

    method: str
    path: str  # percent-encoded
    query: str = ""  # without the question mark, percent-encoded
    headers: tuple[tuple[str, str], ...] = ()
    body: bytes = b""
    source_ip: str = "127.0.0.1"
    protocol: str = "HTTP/1.1"

    def header(self, name: str) -> str | None:
        """Return the first header of that name (lower case)."""
        return next((value for key, value in self.headers if key.lower() == name), None)


def message(status: int, text: str) -> Response:
    """Return one of API Gateway's own answers: `{"message": …}`."""
    return Response(
        status,
        {"content-type": "application/json"},
        json.dumps({"message": text}, separators=(",", ":")).encode(),
    )


def to_event(
    request: Request, route_key: str, path_parameters: Mapping[str, str], request_id: str, now: float
) -> dict[str, Any]:
    """Make the event that a function behind an HTTP API gets for this request.

    `rawPath` is decoded, as HTTP APIs deliver it (REST APIs and function URLs do not); `rawQueryString` is
    not. Absent parts are absent, not empty.
    """
    headers, cookies = _headers(request)
    host = headers.get("host", "localhost")
    path = unquote(request.path)
    event: dict[str, Any] = {
        "version": "2.0",
        "routeKey": route_key,
        "rawPath": path,
        "rawQueryString": request.query,
        "headers": headers
        | {
            "content-length": str(len(request.body)),
            "x-amzn-trace-id": f"Root=1-{int(now):08x}-{request_id.replace('-', '')[:24]}",
            "x-forwarded-for": ", ".join(filter(None, (headers.get("x-forwarded-for"), request.source_ip))),
            "x-forwarded-port": host.partition(":")[2] or "80",
            "x-forwarded-proto": "http",
        },
        "requestContext": {
            "accountId": ACCOUNT,
            "apiId": API_ID,
            "domainName": host.partition(":")[0],
            "domainPrefix": host.partition(":")[0].partition(".")[0],
            "http": {
                "method": request.method,
                "path": path,
                "protocol": request.protocol,
                "sourceIp": request.source_ip,
                "userAgent": headers.get("user-agent", ""),
            },
            "requestId": request_id,
            "routeKey": route_key,
            "stage": "$default",
            "time": datetime.fromtimestamp(now, UTC).strftime("%d/%b/%Y:%H:%M:%S +0000"),
            "timeEpoch": int(now * 1000),
        },
        "isBase64Encoded": False,
    }
    if cookies:
        event["cookies"] = cookies
    if request.query:
        event["queryStringParameters"] = _query(request.query)
    if path_parameters:
        event["pathParameters"] = dict(path_parameters)
    if request.body:
        event["body"], event["isBase64Encoded"] = _body(request.body, headers.get("content-type", ""))
    return event


def to_response(answer: Mapping[str, Any]) -> Response:
    """Convert a handler's result to an HTTP response."""
    headers = {"content-type": "text/plain; charset=utf-8"}
    for name, value in answer.get("headers", {}).items():
        if name.lower() not in _HOP_BY_HOP | {"content-length"}:
            headers[name.lower()] = str(value)
    body = answer.get("body") or ""
    content = base64.b64decode(body) if answer.get("isBase64Encoded") else body.encode()
    return Response(answer["statusCode"], headers, content)


def _headers(request: Request) -> tuple[dict[str, str], list[str]]:
    headers: dict[str, str] = {}
    cookies: list[str] = []
    for name, value in request.headers:
        name = name.lower()
        if name == "cookie":
            cookies += [cookie for cookie in value.split("; ") if cookie]
        elif name not in _HOP_BY_HOP:
            headers[name] = f"{headers[name]},{value}" if name in headers else value
    return headers, cookies


def _query(query: str) -> dict[str, str]:
    parameters: dict[str, str] = {}
    for name, value in parse_qsl(query, keep_blank_values=True):
        parameters[name] = f"{parameters[name]},{value}" if name in parameters else value
    return parameters


def _body(body: bytes, content_type: str) -> tuple[str, bool]:
    if content_type.lower().startswith(_TEXT):
        try:
            return body.decode("utf-8"), False
        except UnicodeDecodeError:
            pass  # JSON could not carry it as text; the function refuses it, not the gateway.
    return base64.b64encode(body).decode("ascii"), True
