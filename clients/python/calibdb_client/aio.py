"""The asynchronous client: the same calls, awaited."""

from __future__ import annotations

import asyncio
import functools
import inspect
import random
from collections.abc import Awaitable, Callable, Coroutine
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Concatenate

import httpx

from .client import Client, P, Service, annotated
from .connection import MAX_ATTEMPTS, RESPONSE_TIMEOUT_S, Body, BodyTooLargeError, failure
from .errors import CalibDBError
from .flows import Flow, T
from .wire import Failure, Reply, Request, pause, require_success

if TYPE_CHECKING:
    from typing import Self


@dataclass(frozen=True)
class _End:
    """End of a conversation, and its result."""

    value: Any


def awaited(
    call: Callable[Concatenate[Client, P], T], *, in_thread: bool = False
) -> Callable[Concatenate[AsyncClient, P], Coroutine[Any, Any, T]]:
    """Make the asynchronous twin of a call of `Client`; its own work runs `in_thread` if it takes long."""
    conversation: Callable[..., Flow[T]] = inspect.unwrap(call)

    @functools.wraps(call)
    async def method(client: AsyncClient, /, *arguments: P.args, **options: P.kwargs) -> T:
        return await client._run(conversation(client, *arguments, **options), in_thread)

    return annotated(method)


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
        """Drive a conversation to its end; its own work `in_thread`, if it takes long."""

        def step(advance: Callable[..., Request], *given: Any) -> Request | _End:
            try:
                return advance(*given)
            except StopIteration as end:  # no thread can pass it on
                return _End(end.value)

        async def go(advance: Callable[..., Request], *given: Any) -> Request | _End:
            return await asyncio.to_thread(step, advance, *given) if in_thread else step(advance, *given)

        request = await go(next, flow)
        while not isinstance(request, _End):
            try:
                reply = await self._exchange(request)
            except CalibDBError as error:
                request = await go(flow.throw, error)
            else:
                request = await go(flow.send, reply)
        result: T = request.value
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
        return require_success(outcome, self.site)

    async def _send(self, message: dict[str, Any]) -> Reply | Failure:
        body = Body()
        try:
            async with self._http.stream(**message) as response:
                async for part in response.aiter_bytes():
                    body.add(part)
        except (httpx.HTTPError, httpx.InvalidURL, BodyTooLargeError) as error:
            return failure(error)
        return body.reply(response)
