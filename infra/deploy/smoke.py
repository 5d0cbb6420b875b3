"""Smoke test of a deployment: a few requests that change nothing."""

from __future__ import annotations

import http.client
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from urllib.parse import urlsplit

_SMOKE_TIMEOUT_S = 20.0  # s: the first request of all starts a function


@dataclass(frozen=True)
class Response:
    """An HTTP response; names of headers in lower case."""

    status: int
    headers: dict[str, str]
    body: bytes


Ask = Callable[[str, str], Response]
"""Method and path to answer."""


def make_requester(url: str) -> Ask:
    """Build a function that sends requests to `url`, which ends without slash."""
    parts = urlsplit(url)
    kind = http.client.HTTPSConnection if parts.scheme == "https" else http.client.HTTPConnection

    def ask(method: str, path: str) -> Response:
        connection = kind(parts.netloc, timeout=_SMOKE_TIMEOUT_S)
        try:
            connection.request(method, path)
            response = connection.getresponse()
            return Response(
                response.status, {k.lower(): v for k, v in response.getheaders()}, response.read()
            )
        finally:
            connection.close()

    return ask


def problems(ask: Ask) -> Iterator[str]:
    """Find the problems of the deployment."""
    for method, path, status in (
        ("GET", "/healthz", 200),
        ("GET", "/", 200),
        ("GET", "/calibrate/", 200),
        ("GET", "/openapi.json", 200),
        ("GET", "/config.json", 200),
        ("GET", "/v1/lookup", 401),
        ("POST", "/v1/auth", 401),
        ("GET", "/v1/auth", 405),
    ):
        heard = ask(method, path)
        if heard.status != status:
            yield f"{method} {path}: {heard.status}, not {status}"
    page = ask("GET", "/calibrate/")
    for header in ("content-security-policy", "x-content-type-options"):
        if header not in page.headers:
            yield f"GET /calibrate/: no {header}"
    settings = json.loads(ask("GET", "/config.json").body or b"{}")
    if not str(settings.get("token", "")).startswith("cdb_"):
        yield "GET /config.json: no token"
