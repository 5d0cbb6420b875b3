"""The client: the service's calls as methods."""

from __future__ import annotations

import functools
import inspect
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec

import httpx

from . import checks, flows, session
from .cache import Cache, default_folder
from .calibration import Answer, Calibration
from .checks import CheckResult, Comparison
from .connection import MAX_ATTEMPTS, RESPONSE_TIMEOUT_S, Body, BodyTooLargeError, Connection, Result, failure
from .files import ExportedFile, PictureChange
from .flows import Flow, T, segment
from .key import AUTO, DEFAULT_MODEL, CameraKey, HasLabel, checked_model, key_of, live_model
from .recording import Progress, Recording, ignore
from .rig import Rig
from .session import CaptureResult
from .wire import Failure, Reply, Request

if TYPE_CHECKING:
    from typing import Unpack

    from .board import Board
    from .capture.operation import CaptureOptions, Keep


P = ParamSpec("P")


class Service:
    """Base of both clients: the connection to a service, and its cache."""

    def __init__(
        self, url: str | None, token: str | None, timeout: float, attempts: int, cache: bool | str | Path
    ) -> None:
        self._connection = Connection.of(url, token, timeout, attempts)
        folder = default_folder() if cache is True else cache
        self._cache = None if folder is False else Cache(Path(folder), time.time)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._connection.site!r})"

    @property
    def site(self) -> str:
        """Address of the service."""
        return self._connection.site

    def _calibration(self, record: Mapping[str, Any]) -> Calibration:
        return Calibration(record)

    def _rig(self, record: Mapping[str, Any]) -> Rig:
        return Rig(record)


def driven(call: Callable[Concatenate[Any, P], Flow[T]]) -> Callable[Concatenate[Client, P], T]:
    """Make a method of `Client` that returns, and says that it returns, the result of a conversation."""

    @functools.wraps(call)
    def method(client: Client, /, *arguments: P.args, **options: P.kwargs) -> T:
        return client._run(call(client, *arguments, **options))

    signature = inspect.signature(call)
    result = signature.return_annotation.removeprefix("Flow[").removesuffix("]")
    method.__annotations__ = {**call.__annotations__, "return": result}
    method.__signature__ = signature.replace(return_annotation=result)  # type: ignore[attr-defined]
    return method


class Client(Service):
    """A client of one service. Use it in a `with` statement, or call `close`.

    Parameters
    ----------
    url, token
        Address of the service and API token; `CALIBDB_URL` and `CALIBDB_TOKEN` by default.
    timeout
        Seconds for an answer.
    attempts
        Number of times that a request is sent before its failure is believed.
    cache
        Folder for cached responses; True: the user's cache folder; False: none.
    transport, sleep
        For tests: replaces the network, and the pauses between attempts.

    Every call raises the errors of `calibdb_client.errors`. A client may be used by one thread at a time.
    """

    def __init__(
        self,
        url: str | None = None,
        token: str | None = None,
        *,
        timeout: float = RESPONSE_TIMEOUT_S,
        attempts: int = MAX_ATTEMPTS,
        cache: bool | str | Path = True,
        transport: httpx.BaseTransport | None = None,
        sleep: Callable[[float], object] = time.sleep,
    ) -> None:
        super().__init__(url, token, timeout, attempts, cache)
        self._http = httpx.Client(**self._connection.arguments(), transport=transport)
        self._sleep = sleep

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the connections."""
        self._http.close()

    @driven
    def lookup(
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
    ) -> Flow[Answer]:
        """Look up the calibration of a camera.

        Parameters
        ----------
        camera
            An open camera, a `CameraKey`, or a label as a browser gives it.
        platform, size, zoom
            As in `key_of`; they replace what the camera says.
        device
            Model identifier of a phone, such as ``iPhone17,3``.
        reported
            Field of view that the device reports: ``focal_35mm`` in mm, ``hfov_deg`` or ``dfov_deg``. Only
            the estimate uses it.
        views
            Views of the camera in the mode in which it is. If its calibrations fall into groups, the estimate
            is the group that fits; at most five views are sent.
        """
        key = key_of(camera, platform, size, zoom).with_device(device)
        facts = flows.facts(reported, views)
        return flows.lookup(key, checked_model(model), self.site, self._cache, self._calibration, facts)

    @driven
    def calibration(self, identifier: str) -> Flow[Calibration]:
        """Read one stored calibration, or one consensus, by its id."""
        reply = yield Request("GET", f"v1/calibrations/{segment(identifier)}")
        return self._calibration(reply.json)

    @driven
    def export(
        self,
        identifier: str,
        format: str,  # noqa: A002 - the contract's name
        *,
        crop: Sequence[int] | None = None,
        resize: Sequence[int] | None = None,
        rotate: int = 0,
        mirror: bool = False,
    ) -> Flow[ExportedFile]:
        """Read a calibration as another tool's file (docs/formats.md), of a changed picture if asked for.

        Parameters
        ----------
        identifier
            Id of the calibration or consensus.
        crop
            Left, top, width, height of the part that is cut out first, px.
        resize
            Width and height to which it is then scaled, px.
        rotate
            Degrees clockwise after that: 0, 90, 180 or 270.
        mirror
            True: left and right are swapped, as the last step.
        """
        query = {"format": format, **PictureChange(crop, resize, rotate, mirror).query()}
        return flows.file(f"v1/calibrations/{segment(identifier)}", query, "calibration")

    @driven
    def rig(self, identifier: str) -> Flow[Rig]:
        """Read a rig, cameras that were calibrated together, by its id. Raises NotFoundError for none."""
        reply = yield Request("GET", f"v1/rigs/{segment(identifier)}/result")
        return self._rig(reply.json)

    @driven
    def rig_file(self, identifier: str, format: str) -> Flow[ExportedFile]:  # noqa: A002 - the contract's name
        """Read a rig as another tool's file (docs/formats.md); several files are one ZIP archive."""
        unnamed = "rig.json" if format == "json" else "rig"
        return flows.file(f"v1/rigs/{segment(identifier)}/result", {"format": format}, unnamed)

    @driven
    def cameras(self, query: str = "", limit: int = 50) -> Flow[list[Mapping[str, Any]]]:
        """Search the database for cameras whose names contain words that begin with those of `query`."""
        return flows.cameras(query, limit)

    @driven
    def camera(self, key: str) -> Flow[Mapping[str, Any]]:
        """Read one camera of the database by its key."""
        reply = yield Request("GET", f"v1/cameras/{segment(key)}")
        return reply.json

    @driven
    def submit(
        self,
        recording: Recording,
        model: str = AUTO,
        progress: Progress | None = None,
        *,
        licence: str | None = None,
        mode_name: str | None = None,
    ) -> Flow[CaptureResult]:
        """Send the corners of a recording; those that agree become a calibration of the database.

        Parameters
        ----------
        model
            Distortion model; ``auto`` is the one that predicts views best that it did not see.
        progress
            Called with the number of views sent, and of all views.
        licence
            ``CC0-1.0``: the contributor agrees that the corners and the calibration are given away under CC0
            1.0. Without it they count in consensuses and stay out of the public dumps.
        mode_name
            Public name of the mode that the camera is in, such as ``stabilisation on``.

        Raises CaptureError if the views do not suffice.
        """
        consent = session.consent_of(licence, mode_name)
        return session.submit(recording, model, self._calibration, progress, consent)

    @driven
    def calibrate(
        self,
        camera: Any,
        *,
        model: str = AUTO,
        licence: str | None = None,
        mode_name: str | None = None,
        keep: Keep | None = None,
        **options: Unpack[CaptureOptions],
    ) -> Flow[CaptureResult]:
        """Calibrate a camera live, guided by the service, hands-free. Only the corners are sent.

        Parameters
        ----------
        camera
            An open camera, an index, path or name of one here, the address of a stream, a video file, or any
            object with `read()`.
        model, licence, mode_name
            As in `submit`; ``auto`` is rectilinear.
        keep
            Called with the recording after every view, to save it.
        options
            As in `CaptureOptions`.

        Raises CameraError, CaptureError, and CaptureInterruptedError on Ctrl-C; their `recording` is what was
        captured.
        """
        from .capture.guide import ServiceGuide
        from .capture.operation import prepare

        consent = session.consent_of(licence, mode_name)
        guide = functools.partial(
            ServiceGuide, model=live_model(model), make=self._calibration, consent=consent
        )
        return (yield from prepare(camera, **options).run(guide, keep or ignore))

    @driven
    def check(
        self,
        camera: Any,
        *,
        model: str = DEFAULT_MODEL,
        licence: str | None = None,
        **options: Unpack[CaptureOptions],
    ) -> Flow[CheckResult]:
        """Check the database's calibration of a camera on three still frames. Parameters as of `calibrate`.

        A `Recording` is checked as it is. Raises NotFoundError if there is nothing to check.
        """
        from .capture.glances import recording_to_check

        consent = session.consent_of(licence)
        recording = recording_to_check(camera, **options)
        return (yield from checks.check(recording, checked_model(model), self._calibration, consent))

    @driven
    def check_against(
        self, camera: Any, calibration: Calibration | str, **options: Unpack[CaptureOptions]
    ) -> Flow[Comparison]:
        """Check a calibration, or that of an id, on still frames of a camera, or a `Recording`.

        The service compares it with a fit of at most five views. No vote counts, nothing is stored.
        `offline.check` does the same on this machine. Raises as `calibration` and `check` do.
        """
        from .capture.glances import recording_to_check

        if isinstance(calibration, str):
            reply = yield Request("GET", f"v1/calibrations/{segment(calibration)}")
            calibration = Calibration(reply.json)
        return (yield from checks.compare_by_service(recording_to_check(camera, **options), calibration))

    @driven
    def calibrate_images(
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
    ) -> Flow[CaptureResult]:
        """Calibrate a camera from pictures of a board. Only the corners are sent.

        Parameters
        ----------
        paths
            Pictures, folders of pictures, or one video file.
        camera
            The camera that took them, or its label; the size is the pictures'.
        board
            Recognised by default.
        platform, zoom
            As in `key_of`; ``photographs`` is the platform of a bare label.
        model, licence, mode_name
            As in `submit`.

        Raises CaptureError if they do not suffice, MissingPackageError without OpenCV.
        """
        from .images import recording_of

        consent = session.consent_of(licence, mode_name)
        recording = recording_of(paths, camera, board, platform, zoom)
        return (yield from session.submit(recording, model, self._calibration, consent=consent))

    def _calibration(self, record: Mapping[str, Any]) -> Calibration:
        return Calibration(record, self.export)

    def _rig(self, record: Mapping[str, Any]) -> Rig:
        return Rig(record, self.rig_file, self.export)

    def _run(self, flow: Flow[T]) -> T:
        steps = self._connection.steps(flow)
        outcome: Reply | Failure | None = None
        while True:
            step = steps.send(outcome)
            if isinstance(step, Result):
                return step.value
            outcome = self._send(step) if isinstance(step, dict) else None
            if isinstance(step, float):
                self._sleep(step)

    def _send(self, message: dict[str, Any]) -> Reply | Failure:
        body = Body()
        try:
            with self._http.stream(**message) as response:
                for part in response.iter_bytes():
                    body.add(part)
        except (httpx.HTTPError, httpx.InvalidURL, BodyTooLargeError) as error:
            return failure(error)
        return body.reply(response)
