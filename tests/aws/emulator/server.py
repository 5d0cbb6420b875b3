"""The front of the local stack: API, client and the client's settings from one origin, over real sockets."""

from __future__ import annotations

import asyncio
import logging
import re
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from starlette.requests import ClientDisconnect
from starlette.requests import Request as WebRequest
from starlette.responses import JSONResponse
from starlette.responses import Response as WebResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from infra.server.app import is_loopback
from infra.server.pages import Pages
from infra.web_build.site import Options
from tests.aws.emulator.events import Request, Response
from tests.aws.emulator.gateway import INTEGRATION_TIMEOUT_S, MAX_BODY_BYTES, Gateway

_access = logging.getLogger("tests.aws.emulator.access")
_MISDIRECTED = JSONResponse({"message": "This server answers to localhost and 127.0.0.1 only."}, 421)


BODY_TIMEOUT_S = 30.0
"""Time for a request's body."""


class GatewayApp:
    """The ASGI application.

    Parameters
    ----------
    gateway
        Answers what lies under the first segments of its routes.
    workers
        Threads for the functions.
    web
        Folder of the static client; answers everything else.
    settings
        Content of `/config.json`.
    timeout
        Seconds until the gateway gives up on a function.
    options
        What the pages say about the deployment.
    """

    def __init__(
        self,
        gateway: Gateway,
        workers: ThreadPoolExecutor,
        web: Path,
        settings: Mapping[str, Any],
        timeout: float = INTEGRATION_TIMEOUT_S,
        options: Options | None = None,
    ):
        self._gateway = gateway
        self._workers = workers
        self._timeout = timeout
        self._site = Pages(web, settings, options)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        start = time.perf_counter()
        status = 0

        async def watched(event: Message) -> None:
            nonlocal status
            if event["type"] == "http.response.start":
                status = event["status"]
            await send(event)

        path = scope["raw_path"].decode("ascii", "replace")
        is_result = re.fullmatch("(/[a-z]{2})?/result/", path) is not None
        if is_result:  # as the edge asks for it
            scope = {**scope, "raw_path": scope["raw_path"] + b"index.html"}
        app: ASGIApp = self._api if is_result or self._gateway.routes.owns(path) else self._site
        if not all(is_loopback(v.decode("latin-1")) for k, v in scope["headers"] if k == b"host"):
            app = _MISDIRECTED
        try:
            await app(scope, receive, watched)
        finally:
            # No query, no headers, no address: they hold tokens and people.
            _access.info(
                "%s %s %s %.1f ms",
                scope["method"],
                path,
                status or "aborted",
                (time.perf_counter() - start) * 1000,
            )

    async def _api(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            request = await asyncio.wait_for(_read(scope, receive), BODY_TIMEOUT_S)
        except ClientDisconnect:
            return  # nobody is left to answer
        except TimeoutError:
            late = JSONResponse({"message": "Request Timeout"}, 408, {"connection": "close"})
            await late(scope, receive, send)
            return
        if request is None:
            origin = WebRequest(scope).headers.get("origin")
            response = self._gateway.refuse(413, "Request Entity Too Large", origin)
        else:
            response = await self._answer(request)
        web = WebResponse(response.body, response.status, dict(response.headers))
        for cookie in response.cookies:
            web.headers.append("set-cookie", cookie)
        await web(scope, receive, send)

    async def _answer(self, request: Request) -> Response:
        loop = asyncio.get_running_loop()
        call = loop.run_in_executor(self._workers, self._gateway.handle, request)
        try:
            return await asyncio.wait_for(asyncio.shield(call), self._timeout)
        except TimeoutError:
            # The function goes on, as on AWS, where it has a timeout of its own.
            return self._gateway.refuse(503, "Service Unavailable", request.header("origin"))


async def _read(scope: Scope, receive: Receive) -> Request | None:
    """Return the whole request, None if it is larger than a function could be handed."""
    body = bytearray()
    async for chunk in WebRequest(scope, receive).stream():
        body += chunk
        if len(body) > MAX_BODY_BYTES:
            return None
    client = scope.get("client")
    return Request(
        method=scope["method"],
        path=scope["raw_path"].decode("latin-1"),
        query=scope["query_string"].decode("latin-1"),
        headers=tuple((name.decode("latin-1"), value.decode("latin-1")) for name, value in scope["headers"]),
        body=bytes(body),
        source_ip=client[0] if client else "127.0.0.1",
        protocol=f"HTTP/{scope['http_version']}",
    )
