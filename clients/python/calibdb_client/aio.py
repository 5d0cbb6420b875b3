"""The asynchronous client: the same calls, awaited."""

from __future__ import annotations

import asyncio
import functools
import inspect
from collections.abc import Awaitable, Callable, Coroutine
from pathlib import Path
from typing import Any, Concatenate

import httpx

from .client import Client, P, Service
from .connection import MAX_ATTEMPTS, RESPONSE_TIMEOUT_S, Body, BodyTooLargeError, Result, failure
from .flows import Flow, T
from .wire import Failure, Reply


def awaited(
    call: Callable[Concatenate[Client, P], T], *, in_thread: bool = False
) -> Callable[Concatenate[AsyncClient, P], Coroutine[Any, Any, T]]:
    """Make the asynchronous twin of a call of `Client`; `in_thread`: run its own work in a thread."""
    conversation: Callable[..., Flow[T]] = inspect.unwrap(call)

    @functools.wraps(call)
    async def method(client: AsyncClient, /, *arguments: P.args, **options: P.kwargs) -> T:
        return await client._run(conversation(client, *arguments, **options), in_thread)

    return method


class AsyncClient(Service):
    """A client of one service for programs with an event loop. Use it in `async with`, or await `close`.

    Parameters as of `Client`. Its calibrations write files by calibsolver; `export` fetches the service's.
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
        super().__init__(url, token, timeout, attempts, cache)
        self._http = httpx.AsyncClient(**self._connection.arguments(), transport=transport)
        self._sleep = sleep

    async def __aenter__(self) -> AsyncClient:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Close the connections."""
        await self._http.aclose()

    lookup = awaited(Client.lookup)
    calibration = awaited(Client.calibration)
    export = awaited(Client.export)
    rig = awaited(Client.rig)
    rig_file = awaited(Client.rig_file)
    cameras = awaited(Client.cameras)
    camera = awaited(Client.camera)
    submit = awaited(Client.submit)
    calibrate = awaited(Client.calibrate, in_thread=True)
    calibrate_images = awaited(Client.calibrate_images, in_thread=True)
    check = awaited(Client.check, in_thread=True)
    check_against = awaited(Client.check_against, in_thread=True)

    async def _run(self, flow: Flow[T], in_thread: bool) -> T:
        steps = self._connection.steps(flow)
        outcome: Reply | Failure | None = None
        while True:
            step = await asyncio.to_thread(steps.send, outcome) if in_thread else steps.send(outcome)
            if isinstance(step, Result):
                return step.value
            outcome = await self._send(step) if isinstance(step, dict) else None
            if isinstance(step, float):
                await self._sleep(step)

    async def _send(self, message: dict[str, Any]) -> Reply | Failure:
        body = Body()
        try:
            async with self._http.stream(**message) as response:
                async for part in response.aiter_bytes():
                    body.add(part)
        except (httpx.HTTPError, httpx.InvalidURL, BodyTooLargeError) as error:
            return failure(error)
        return body.reply(response)
