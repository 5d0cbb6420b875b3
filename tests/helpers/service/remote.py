"""A server in another process, as `Client` speaks to it."""

from collections.abc import Mapping
from typing import Self

import httpx

from tests.helpers.service.in_process import Response


class Remote:
    def __init__(self, url: str) -> None:
        self.http = httpx.Client(base_url=url, timeout=60)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.http.close()

    def request(
        self,
        method: str,
        path: str,
        headers: Mapping[str, str] | None = None,
        query: str = "",
        body: bytes = b"",
    ) -> Response:
        """Response of the server; raises httpx.TransportError if it is gone."""
        address = f"{path}?{query}" if query else path
        answer = self.http.request(method, address, headers=dict(headers or {}), content=body)
        return Response(answer.status_code, dict(answer.headers), answer.content)
