"""Calibration on this machine, with calibsolver: nothing is sent.

The results can be sent later: `Recording.save`, then `Client.submit` or ``calibdb submit FILE``.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

from .key import DEFAULT_MODEL, UNNAMED, checked_model
from .recording import Recording, ignore
from .session import CaptureResult, calibrate_offline

if TYPE_CHECKING:
    from .board import Board
    from .capture.operation import CaptureOptions, Keep


def calibrate(
    camera: Any,
    *,
    model: str = DEFAULT_MODEL,
    keep: Keep | None = None,
    **options: Unpack[CaptureOptions],
) -> CaptureResult:
    """Calibrate a camera live, guided by calibsolver. Parameters and errors as of `Client.calibrate`."""
    from .capture.operation import prepare

    operation = prepare(camera, named=False, **options)
    return _run(operation.offline(checked_model(model), keep or ignore))


def calibrate_images(
    paths: str | Path | Iterable[str | Path],
    camera: str = UNNAMED,
    *,
    board: Board | None = None,
    model: str = DEFAULT_MODEL,
) -> CaptureResult:
    """Calibrate a camera from pictures, or one video. Parameters as of `Client.calibrate_images`."""
    from .images import recording_of

    return calibrate_recording(recording_of(paths, camera, board), model)


def calibrate_recording(recording: Recording, model: str = DEFAULT_MODEL) -> CaptureResult:
    """Calibrate from captured corners. Raises CaptureError if they do not suffice."""
    return calibrate_offline(recording, checked_model(model), int(time.time()))


def _run(flow: Generator[Any, Any, CaptureResult]) -> CaptureResult:
    """Return the result of a conversation that asks nobody."""
    try:
        next(flow)
    except StopIteration as end:
        result: CaptureResult = end.value
        return result
    raise RuntimeError("a capture offline sends nothing")
