"""The asynchronous client: the same calls, awaited."""

from __future__ import annotations

import asyncio
import random
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

import httpx

from . import checks, flows, session
from .answer import Answer
from .calibration import Calibration
from .checks import CheckResult
from .client import open_cache
from .connection import MAX_ATTEMPTS, RESPONSE_TIMEOUT_S, Body, BodyTooLargeError, Connection, failure
from .errors import CalibDBError
from .files import ExportedFile
from .key import AUTO, DEFAULT_MODEL, CameraKey, HasLabel, checked_model, key_of, live_model
from .picture_change import PictureChange
from .recording import Recording, ignore
from .rig import Rig
from .session import CaptureResult, Progress
from .wire import Failure, Reply, Request, pause, require_success

if TYPE_CHECKING:
    from typing import Self, Unpack

    from .board import Board
    from .capture.operation import CaptureOptions, Keep
    from .comparison import Comparison


@dataclass(frozen=True)
class _End:
    """End of a conversation, and its result."""

    value: Any


class AsyncClient:
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
        device: str | None = None,
        reported: Mapping[str, float] | None = None,
        views: Recording | None = None,
    ) -> Answer:
        """Look up the calibration of a camera, as `Client.lookup` does."""
        key = key_of(camera, platform, size, zoom).with_device(device)
        facts = flows.facts(reported, views)
        return await self._run(flows.lookup(key, checked_model(model), self._edge, Calibration, facts))

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
        change = PictureChange(crop, resize, rotate, mirror)
        return await self._run(flows.export(identifier, {"format": format, **change.query()}))

    async def rig(self, identifier: str) -> Rig:
        """Read a rig by its id, as `Client.rig` does."""
        return Rig(await self._run(flows.rig(identifier)))

    async def rig_file(self, identifier: str, format: str) -> ExportedFile:  # noqa: A002 - the contract's name
        """Read a rig as another tool's file, as `Client.rig_file` does."""
        return await self._run(flows.rig_file(identifier, format))

    async def cameras(self, query: str = "", limit: int = 50) -> list[Mapping[str, Any]]:
        """Search the database, as `Client.cameras` does."""
        return await self._run(flows.cameras(query, limit))

    async def camera(self, key: str) -> Mapping[str, Any]:
        """Read one camera of the database by its key."""
        return await self._run(flows.camera(key))

    async def submit(
        self,
        recording: Recording,
        model: str = AUTO,
        progress: Progress | None = None,
        *,
        licence: str | None = None,
        mode_name: str | None = None,
    ) -> CaptureResult:
        """Send the corners of a recording, as `Client.submit` does."""
        extras = session.extras_of(licence, mode_name)
        return await self._run(session.submit(recording, model, Calibration, progress, extras))

    async def calibrate_images(
        self,
        paths: str | Path | Iterable[str | Path],
        camera: CameraKey | HasLabel | str,
        *,
        board: Board | None = None,
        platform: str | None = None,
        zoom: float | None = None,
        model: str = AUTO,
        licence: str | None = None,
        mode_name: str | None = None,
    ) -> CaptureResult:
        """Calibrate a camera from pictures of a board, as `Client.calibrate_images` does."""
        from .images import recording_of

        recording = await asyncio.to_thread(recording_of, paths, camera, board, platform, zoom)
        return await self.submit(recording, model, licence=licence, mode_name=mode_name)

    async def calibrate(
        self,
        camera: Any,
        *,
        model: str = AUTO,
        licence: str | None = None,
        mode_name: str | None = None,
        keep: Keep | None = None,
        **options: Unpack[CaptureOptions],
    ) -> CaptureResult:
        """Calibrate a camera live, as `Client.calibrate` does with the same parameters.

        Frames are read in a thread, requests are awaited.
        """
        from .capture.operation import prepare

        extras = session.extras_of(licence, mode_name)
        operation = await asyncio.to_thread(prepare, camera, **options)
        flow = operation.by_service(live_model(model), keep or ignore, Calibration, extras)
        return await self._run(flow, in_thread=True)

    async def check(
        self,
        camera: Any,
        *,
        model: str = DEFAULT_MODEL,
        licence: str | None = None,
        **options: Unpack[CaptureOptions],
    ) -> CheckResult:
        """Check the calibration of a camera, as `Client.check` does with the same parameters."""
        from .capture.glances import recording_to_check

        consent = session.consent_of(licence)
        recording = await asyncio.to_thread(recording_to_check, camera, **options)
        return await self._run(checks.check(recording, checked_model(model), Calibration, consent))

    async def check_against(
        self, camera: Any, calibration: Calibration | str, **options: Unpack[CaptureOptions]
    ) -> Comparison:
        """Check a calibration at hand, as `Client.check_against` does with the same parameters."""
        from . import comparison
        from .capture.glances import recording_to_check

        stored = await self.calibration(calibration) if isinstance(calibration, str) else calibration
        recording = await asyncio.to_thread(recording_to_check, camera, **options)
        return await self._run(comparison.by_service(recording, stored))

    async def _run(self, flow: flows.Flow[flows.T], in_thread: bool = False) -> flows.T:
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
        result: flows.T = request.value
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
