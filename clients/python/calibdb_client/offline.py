"""Calibration on this machine, with calibsolver: nothing is sent.

The results can be sent later: `Recording.save`, then `Client.submit` or ``calibdb submit FILE``.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .key import AUTO, UNNAMED, live_model
from .recording import Recording, ignore
from .session import CaptureResult, calibrate_offline

if TYPE_CHECKING:
    from typing import Unpack

    from calibsolver.fitting.constraint import Fix

    from .board import Board
    from .calibration import Calibration
    from .capture.operation import CaptureOptions, Keep
    from .comparison import Comparison
    from .rig_pictures import RigResult


def calibrate(
    camera: Any,
    *,
    model: str = AUTO,
    keep: Keep | None = None,
    **options: Unpack[CaptureOptions],
) -> CaptureResult:
    """Calibrate a camera live, guided by calibsolver. Parameters and errors as of `Client.calibrate`."""
    from .capture.operation import prepare

    operation = prepare(camera, named=False, **options)
    result = _run(operation.offline(live_model(model), keep or ignore))
    taken = result.calibration.recording
    return calibrate_recording(taken) if model == AUTO and taken else result


def calibrate_images(
    paths: str | Path | Iterable[str | Path],
    camera: str = UNNAMED,
    *,
    board: Board | None = None,
    model: str = AUTO,
    fix: Fix = (),
    start: Calibration | None = None,
) -> CaptureResult:
    """Calibrate a camera from pictures, or one video.

    Parameters as of `Client.calibrate_images` and of `calibrate_recording`.
    """
    from .images import recording_of

    return calibrate_recording(recording_of(paths, camera, board), model, fix=fix, start=start)


def calibrate_rig(
    folders: Sequence[str | Path],
    *,
    board: Board | None = None,
    model: str = AUTO,
    square_size: float | None = None,
) -> RigResult:
    """Calibrate cameras that do not move against each other from a folder of pictures of each.

    Parameters
    ----------
    folders
        By position. Pictures with the same file name show the same moment; if no names are the same, those at
        the same place in the order of names do.
    board, model
        The board, recognised unless given; the distortion model, chosen for each camera if ``auto``.
    square_size
        Side of a square, or of a tag, metres: lengths are then metres, else squares.

    Raises UsageError if the folders cannot be paired, CaptureError if the pictures do not suffice.
    """
    from . import rig_pictures

    return rig_pictures.calibrate_rig(folders, board=board, model=model, square_size=square_size)


def check(recording: Recording, calibration: Calibration) -> Comparison:
    """Check a calibration against fresh views. Raises UsageError or CaptureError as `compare` does."""
    from .comparison import compare

    return compare(recording, calibration)


def calibrate_recording(
    recording: Recording, model: str = AUTO, *, fix: Fix = (), start: Calibration | None = None
) -> CaptureResult:
    """Calibrate from captured corners.

    Parameters
    ----------
    recording, model
        The corners, and the distortion model.
    fix, start
        What is not estimated, and a calibration that may be near, as in `calibsolver.fit`.

    Raises CaptureError if they do not suffice, UsageError if a parameter cannot be fixed.
    """
    return calibrate_offline(recording, model, int(time.time()), fix, start)


def _run(flow: Generator[Any, Any, CaptureResult]) -> CaptureResult:
    """Return the result of a conversation without network."""
    try:
        next(flow)
    except StopIteration as end:
        result: CaptureResult = end.value
        return result
    raise RuntimeError("a capture offline sends nothing")
