"""The ASGI application: the API of `functions/*`, the public dumps, and the site."""

import asyncio
import importlib
import logging
import re
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Match, Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from calibdb.http.application import IN_THREAD, application, with_default_headers

FUNCTIONS = (
    *("lookup", "health", "auth", "session", "next_pose", "submit"),
    *("rig", "cameras", "export", "checks", "tokens"),
)
MAX_BODY_BYTES = 6 * 1024 * 1024
ORIGINS = ("http://127.0.0.1:*", "http://localhost:*", "http://[::1]:*")
"""Origins of pages of this machine, at any port."""
_LOOPBACK = re.compile(
    r"(?:127(?:\.[0-9]{1,3}){3}|localhost|(?:[a-z0-9-]{1,63}\.)+localhost|\[::1\])(?::[0-9]{1,5})?"
)
BODY_TIMEOUT_S = 30.0
RESPONSE_TIMEOUT_S = 30.0
_API_PREFIXES = ("/v1/", "/healthz", "/badge/", "/known/")
_EXPOSED = (
    "location,retry-after,etag,ratelimit,ratelimit-policy,content-disposition,"
    "x-conversion-error,x-conversion-coverage,x-conversion-warning"
)
_CORS = [
    (b"access-control-allow-origin", b"*"),
    (b"access-control-expose-headers", _EXPOSED.encode()),
]

_access = logging.getLogger("infra.server.access")


@dataclass(frozen=True)
class Public:
    """Callers that may reach the server, and its name; by default this machine only."""

    url: str | None = None  # "https://calibdb.example"
    proxies: Sequence[str] = ()  # networks of the reverse proxies whose `X-Forwarded-For` is believed

    def allows(self, host: str) -> bool:
        """True if the server answers to this `Host` header."""
        return is_loopback(host) or (self.url is not None and host.lower() == urlsplit(self.url).netloc)


def is_loopback(host: str) -> bool:
    """True if a Host header names this machine; a name that leads here by DNS rebinding does not."""
    return _LOOPBACK.fullmatch(host.strip().lower()) is not None


class App:
    """The application; `site`, `dumps`: those of the pages and of `/dumps/`."""

    def __init__(
        self, site: ASGIApp, dumps: ASGIApp, workers: ThreadPoolExecutor, public: Public = Public()
    ) -> None:
        self._site = site
        self._dumps = dumps
        self._workers = workers
        self._public = public
        self._routes: list[Route] = []
        for name in FUNCTIONS:
            self._routes += importlib.import_module(f"functions.{name}.app").handler.routes
        self._api = with_default_headers(application(*self._routes))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            return
        begun, path, status = time.perf_counter(), scope["path"], 0
        hosts = [value for name, value in scope["headers"] if name == b"host"]
        is_api = path.startswith(_API_PREFIXES)

        async def sending(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                if is_api and origin and scope["method"] != "OPTIONS":
                    own = [h for h in message["headers"] if not h[0].startswith(b"access-control-")]
                    message["headers"] = [*own, *_CORS]
            await send(message)

        origin = any(name == b"origin" for name, _ in scope["headers"])
        app: ASGIApp = self._answer if is_api else self._dumps if path.startswith("/dumps/") else self._site
        if not all(self._public.allows(value.decode("latin-1")) for value in hosts):
            app = _message(421, "This server does not answer to this host name.")
        try:
            await app(scope, receive, sending)
        finally:
            if status >= 400 or status == 0:
                # No query, no headers, no address: they contain tokens and people.
                took_ms = (time.perf_counter() - begun) * 1000
                named = self._name(scope) if is_api else path
                _access.info("%s %s %s %.1f ms", scope["method"], named, status or "aborted", took_ms)

    def _name(self, scope: Scope) -> str:
        """Return the route of a request: a path may contain what is secret."""
        for route in self._routes:
            if route.matches(scope)[0] is not Match.NONE:
                return route.path
        return "unknown path"

    async def _answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request of the API: the body is read here, the endpoint runs in a thread."""
        body = b""
        if any(name in (b"content-length", b"transfer-encoding") for name, _ in scope["headers"]):
            try:
                async with asyncio.timeout(BODY_TIMEOUT_S):
                    body = await _read(Request(scope, receive))
            except TimeoutError:
                await _message(408, "Request Timeout", {"connection": "close"})(scope, receive, send)
                return
            except ClientDisconnect:
                return
        if len(body) > MAX_BODY_BYTES:
            await _message(413, "Request Entity Too Large")(scope, receive, send)
            return
        whole: Message = {"type": "http.request", "body": body, "more_body": False}

        async def receiving() -> Message:
            return whole

        scope[IN_THREAD] = self._in_thread
        await self._api(scope, receiving, send)

    async def _in_thread(self, call: Callable[[], Response]) -> Response:
        future = asyncio.get_running_loop().run_in_executor(self._workers, call)
        done, _ = await asyncio.wait([future], timeout=RESPONSE_TIMEOUT_S)
        # Late, the endpoint continues in its thread, and ends by its own limits.
        return future.result() if done else _message(503, "Service Unavailable")


async def _read(request: Request) -> bytes:
    """Read the body, or its beginning if it is too large."""
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > MAX_BODY_BYTES:
            break
    return bytes(body)


def _message(status: int, text: str, headers: Mapping[str, str] | None = None) -> Any:
    return JSONResponse({"message": text}, status, headers)
