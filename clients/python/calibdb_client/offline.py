"""Calibration on this machine, with calibsolver: nothing is sent.

The results can be sent later: `Recording.save`, then `Client.submit` or ``calibdb submit FILE``.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Iterable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .calibration import Calibration
from .checks import compare as check
from .errors import CaptureError, UsageError
from .key import AUTO, UNNAMED
from .model_choice import chosen_model
from .recording import Recording, ignore
from .rig_pictures import calibrate_rig
from .session import CaptureResult, refusal

if TYPE_CHECKING:
    from typing import Unpack

    from calibsolver.fitting.constraint import Fix

    from .board import Board
    from .capture.operation import CaptureOptions, Keep

__all__ = ["calibrate", "calibrate_images", "calibrate_recording", "calibrate_rig", "check"]


def calibrate(
    camera: Any,
    *,
    model: str = AUTO,
    keep: Keep | None = None,
    **options: Unpack[CaptureOptions],
) -> CaptureResult:
    """Calibrate a camera live, guided by calibsolver. Parameters and errors as of `Client.calibrate`."""
    from .capture.guide import OfflineGuide
    from .capture.operation import prepare

    operation = prepare(camera, named=False, **options)
    return _run(operation.run(partial(OfflineGuide, model=model), keep or ignore))


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


def calibrate_recording(
    recording: Recording, model: str = AUTO, *, fix: Fix = (), start: Calibration | None = None
) -> CaptureResult:
    """Calibrate from captured corners. The shape of the board is estimated too, except that of a circle grid.

    `fix` and `start` say what is not estimated, and a calibration that may be near, as in `calibsolver.fit`.
    With a start, ``auto`` is its model.

    Raises CaptureError if they do not suffice, UsageError if a parameter cannot be fixed.
    """
    import calibsolver
    from calibsolver.board import CIRCLES
    from calibsolver.circles import fit_circles
    from calibsolver.fitting.coverage import Coverage, record_covered
    from calibsolver.quality import assessment, cross_validation
    from calibsolver.quality.rivals import with_rivals

    lens = start.lens if start else None
    chosen, better = chosen_model(recording, lens.model if lens and model == AUTO else model)
    size, flat = recording.key.img_size, recording.board.kind in CIRCLES
    try:
        views = recording.observations()
        if flat:
            radius = recording.board.marker_ratio / 2
            fitted, corrected = fit_circles(views, size, radius, chosen, start=lens, fix=fix)
            views = list(corrected)
        else:
            fitted = calibsolver.fit(views, size, chosen, start=lens, fix=fix)
    except (calibsolver.CalibrationError, ValueError) as error:
        if getattr(error, "code", "") in ("unknown_parameter", "no_value"):
            raise UsageError(str(error)) from None
        other = f"--model {better} fits them" if better else "take more, with the board tilted"
        raise CaptureError(f"these pictures do not determine the model {chosen} ({error}): {other}") from None
    try:
        held_out = cross_validation.held_out(
            views, size, chosen, board_shape=not flat, start=lens, fix=fix
        ).rms
    except calibsolver.CalibrationError:
        held_out = None
    fitted = with_rivals(fitted, views)
    coverage = Coverage.of(fitted, views)
    said = assessment.assess(fitted, views, held_out, coverage)
    cut = tuple((recording.views[n].source, refusal(why)) for n, why in sorted(fitted.cut_views.items()))
    record = {
        **record_covered(fitted, coverage),
        "covariance": fitted.covariance.tolist(),
        **recording.key.record(),
        "id": None,
        "calibrations": 1,
        "contributors": 1,
        "exact_size": True,
        "calibration_time": int(time.time()),
    }
    return CaptureResult(
        Calibration(record, None, recording),
        len(views) - len(cut),
        cut,
        better,
        (said.level, *(reason.text for reason in said.reasons)),
    )


def _run(flow: Generator[Any, Any, CaptureResult]) -> CaptureResult:
    try:
        next(flow)
    except StopIteration as end:
        result: CaptureResult = end.value
        return result
    raise RuntimeError("a capture offline sends nothing")
