"""The asynchronous client: the same calls, awaited."""

from __future__ import annotations

import asyncio
import random
from collections.abc import Awaitable, Callable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import httpx

from . import flows, session
from .answer import Answer, ExportedFile
from .calibration import Calibration
from .client import open_cache
from .connection import MAX_ATTEMPTS, RESPONSE_TIMEOUT_S, Body, BodyTooLargeError, Connection, failure
from .errors import CalibDBError
from .export_query import export_query
from .key import DEFAULT_MODEL, CameraKey, HasLabel, checked_model, key_of
from .recording import Recording
from .session import CaptureResult, Progress
from .wire import Failure, Reply, Request, checked, pause


class AsyncClient:
    """A client of one service for programs with an event loop. Use it in `async with`, or await `close`.

    Parameters as of `Client`. Its calibrations write their own format only; `export` fetches the others.
    """

    def __init__(
        self,
        url: str | None = None,
        token: str | None = None,
        *,
        timeout: float = RESPONSE_TIMEOUT_S,
        attempts: int = MAX_ATTEMPTS,
        cache: bool | str | Path = True,
        transport: httpx.AsyncBaseTransport | None = None,
        sleep: Callable[[float], Awaitable[object]] = asyncio.sleep,
    ) -> None:
        self._connection = Connection.of(url, token, timeout, attempts)
        self._http = httpx.AsyncClient(**self._connection.arguments(), transport=transport)
        self._sleep = sleep
        self._edge = flows.Edge(self._connection.site, open_cache(cache))

    def __repr__(self) -> str:
        return f"AsyncClient({self._connection.site!r})"

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Close the connections."""
        await self._http.aclose()

    @property
    def site(self) -> str:
        """Address of the service."""
        return self._connection.site

    async def lookup(
        self,
        camera: CameraKey | HasLabel | str,
        *,
        platform: str | None = None,
        size: Sequence[int] | None = None,
        zoom: float | None = None,
        model: str = DEFAULT_MODEL,
    ) -> Answer:
        """Look up the calibration of a camera, as `Client.lookup` does."""
        key = key_of(camera, platform, size, zoom)
        return await self._run(flows.lookup(key, checked_model(model), self._edge, Calibration))

    async def calibration(self, identifier: str) -> Calibration:
        """Read one stored calibration, or one consensus, by its id."""
        return Calibration(await self._run(flows.calibration(identifier)))

    async def export(
        self,
        identifier: str,
        format: str,  # noqa: A002 - the contract's name
        *,
        crop: Sequence[int] | None = None,
        resize: Sequence[int] | None = None,
        rotate: int = 0,
        mirror: bool = False,
    ) -> ExportedFile:
        """Read a calibration as another tool's file, as `Client.export` does."""
        return await self._run(flows.export(identifier, export_query(format, crop, resize, rotate, mirror)))

    async def cameras(self, query: str = "", limit: int = 50) -> list[Mapping[str, Any]]:
        """Search the database, as `Client.cameras` does."""
        return await self._run(flows.cameras(query, limit))

    async def camera(self, key: str) -> Mapping[str, Any]:
        """Read one camera of the database by its key."""
        return await self._run(flows.camera(key))

    async def submit(
        self, recording: Recording, model: str = DEFAULT_MODEL, progress: Progress | None = None
    ) -> CaptureResult:
        """Send the corners of a recording, as `Client.submit` does."""
        return await self._run(session.submit(recording, checked_model(model), Calibration, progress))

    async def _run(self, flow: flows.Flow[flows.T]) -> flows.T:
        """Drive a conversation to its end."""
        try:
            request = next(flow)
            while True:
                try:
                    reply = await self._exchange(request)
                except CalibDBError as error:
                    request = flow.throw(error)
                else:
                    request = flow.send(reply)
        except StopIteration as end:
            result: flows.T = end.value
            return result

    async def _exchange(self, request: Request) -> Reply:
        """Send a request until it is answered, at most as often as is allowed."""
        message = self._connection.message(request)
        attempts = self._connection.attempts if request.repeats else 1
        for attempt in range(attempts):
            outcome = await self._send(message)
            wait = pause(outcome, attempt, random.random())  # noqa: S311 - no secret
            if wait is None or attempt + 1 == attempts:
                break
            await self._sleep(wait)
        return checked(outcome, self.site)

    async def _send(self, message: dict[str, Any]) -> Reply | Failure:
        body = Body()
        try:
            async with self._http.stream(**message) as response:
                async for part in response.aiter_bytes():
                    body.add(part)
        except (httpx.HTTPError, httpx.InvalidURL, BodyTooLargeError) as error:
            return failure(error)
        return body.reply(response)
