"""Requests to a server of this process, without a socket."""

import asyncio
import json
import logging
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import unquote

from infra.server.server import Server

_log = logging.getLogger("infra.server")


@dataclass(frozen=True)
class Response:
    """A response; header names are lower case."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)

    @property
    def kind(self) -> str:
        return str(self.json["type"]).rpartition("#")[2]

    @property
    def problem(self) -> tuple[int, str]:
        return self.status, self.kind

    @property
    def fields(self) -> list[str]:
        assert self.status == 422, self
        return [error["field"] for error in self.json["errors"]]


def request(
    server: Server,
    method: str,
    path: str,
    headers: Mapping[str, str] | None = None,
    query: str = "",
    body: bytes = b"",
    client: str = "127.0.0.1",
) -> Response:
    """Send a request; `path` and `query` are percent-encoded, `query` is without its question mark."""
    sent = {"host": server.url.partition("//")[2]} | {
        n.lower(): value for n, value in (headers or {}).items()
    }
    if body:
        sent["content-length"] = str(len(body))
    scope = {
        "type": "http",
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "method": method,
        "scheme": "http",
        "path": unquote(path),
        "raw_path": path.encode(),
        "query_string": query.encode(),
        "root_path": "",
        "headers": [(name.encode("latin-1"), value.encode("latin-1")) for name, value in sent.items()],
        "client": (client, 50_000),
        "server": ("127.0.0.1", 80),
    }
    return asyncio.run(_respond(server, scope, body))


async def _respond(server: Server, scope: dict[str, Any], body: bytes) -> Response:
    status, received, content = 0, {}, bytearray()

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": body, "more_body": False}

    async def send(message: Any) -> None:
        nonlocal status, received
        if message["type"] == "http.response.start":
            status = message["status"]
            received = {n.decode("latin-1").lower(): v.decode("latin-1") for n, v in message["headers"]}
        else:
            content.extend(message.get("body", b""))

    try:
        await server.app(scope, receive, send)
    except Exception:
        if not status:
            raise
        _log.exception("%(method)s %(path)s failed", scope)  # after its response, as uvicorn does
    return Response(status, received, b"" if scope["method"] == "HEAD" else bytes(content))
