"""CloudFront's part: objects under `/known/` and `/dumps/`, with the headers that a deployment gives them."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from starlette.types import Receive, Scope, Send

from infra.local.pages import FOR_EVERYONE

PREFIXES = ("/known/", "/dumps/")
# Where the edge keeps a missing object, for the sake of its origin.
MISSING_CACHE_CONTROL = "public, max-age=10"
_NAME = re.compile(
    r"/(known/[0-9a-f]{2}/[0-9a-f]{32}\.json|dumps/[a-z]+\.json|dumps/[0-9TZ-]+/[a-z]+-[0-9a-f-]+\.jsonl\.gz)"
)
_HEADERS = [(name.encode(), value.encode()) for name, value in FOR_EVERYONE.items()]
_HEADERS.append((b"x-content-type-options", b"nosniff"))
_METHODS = ("GET", "HEAD")

Read = Callable[[str], tuple[bytes, str] | None]
"""Name of an object to its content and ETag, None where there is none."""


class KnownAnswers:
    """The ASGI application: GET and HEAD, the same for all callers, without cookies or query."""

    def __init__(self, read: Read, cache_control: str) -> None:
        self._read = read
        self._cache_control = cache_control.encode()

    async def __call__(self, scope: Scope, _: Receive, send: Send) -> None:
        """Answer one request."""
        match = _NAME.fullmatch(scope["path"])
        method = scope["method"]
        found = self._read(match[1]) if match and method in _METHODS else None
        if method not in _METHODS:
            await _answer(send, 405, b"", [(b"allow", b"GET, HEAD")])
        elif found is None:
            await _answer(send, 404, b"", [(b"cache-control", MISSING_CACHE_CONTROL.encode())])
        else:
            content, etag = found[0], f'"{found[1]}"'.encode()
            headers: list[tuple[bytes, bytes]] = [(b"cache-control", self._cache_control), (b"etag", etag)]
            asked: dict[bytes, bytes] = dict(scope["headers"])
            if asked.get(b"if-none-match") == etag:
                await _answer(send, 304, b"", headers)
            else:
                kind = b"application/gzip" if scope["path"].endswith(".gz") else b"application/json"
                headers.append((b"content-type", kind))
                await _answer(send, 200, content, headers, with_body=method == "GET")


async def _answer(
    send: Send, status: int, content: bytes, headers: list[tuple[bytes, bytes]], *, with_body: bool = True
) -> None:
    length: list[Any] = [] if status == 304 else [(b"content-length", str(len(content)).encode())]
    await send({"type": "http.response.start", "status": status, "headers": [*headers, *_HEADERS, *length]})
    await send({"type": "http.response.body", "body": content if with_body else b""})
