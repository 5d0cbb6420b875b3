"""A recording becomes a calibration: in a session of the service, or on this machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from .calibration import Calibration
from .errors import CaptureError, ConflictError, MissingPackageError
from .flows import Flow
from .recording import Recording
from .wire import Request

Progress = Callable[[int, int], None]
"""Is told how many of how many are done."""
_REASONS = {
    "too_few_points": "too few corners",
    "degenerate": "its corners lie on a line",
    "mirrored": "the picture is mirrored",
    "outlier": "it contradicts the other pictures",
    "disagrees": "it contradicts the other pictures",
}


@dataclass(frozen=True)
class CaptureResult:
    """Result of a capture.

    Attributes
    ----------
    calibration
        The calibration.
    used
        Number of views behind it.
    left_out
        Sources of views that are not, and why.
    suggested_model
        Distortion model that explains these views better, or None.
    verdict
        What the solver thinks of it, level first; empty if the service answered.
    """

    calibration: Calibration
    used: int
    left_out: tuple[tuple[str, str], ...] = ()
    suggested_model: str | None = None
    verdict: tuple[str, ...] = ()


def submit(
    recording: Recording,
    model: str,
    make: Callable[[Mapping[str, Any]], Calibration],
    progress: Progress | None = None,
) -> Flow[CaptureResult]:
    """Send the corners of a recording, and end the session with those that agree.

    Raises CaptureError if they do not suffice.
    """
    reply = yield Request("POST", "v1/auth")
    session = str(reply.json["session_id"])
    start = {
        **recording.key.record(),
        "distortion_model": model,
        "board": recording.board.record(),
        "capture": "recorded",
    }
    yield Request("POST", "v1/session", start, credential=session)
    accepted: list[str] = []
    left_out: list[tuple[str, str]] = []
    for n, view in enumerate(recording.views):
        body = {"index": len(accepted), "ids": list(view.ids), "points": [list(q) for q in view.points]}
        reply = yield Request("POST", "v1/session/views", body, credential=session)
        answer = reply.json
        if answer.get("accepted"):
            accepted.append(view.source)
        else:
            left_out.append((view.source, _words(answer.get("reason"))))
        if progress:
            progress(n + 1, len(recording.views))
    try:
        reply = yield Request("POST", "v1/session/finish", credential=session)
    except ConflictError as error:
        raise CaptureError(f"{error} Take more pictures, with the board tilted in several ways") from None
    state = reply.json
    for source, view_state in zip(accepted, state.get("views", []), strict=False):
        if aside := view_state.get("set_aside"):
            left_out.append((source, _words(aside.get("reason"))))
    record = state.get("calibration")
    if not isinstance(record, dict):
        raise CaptureError("the views determine no calibration: take more pictures, with the board tilted")
    return CaptureResult(
        make({**record, "id": state.get("calibration_id") or record.get("id")}),
        len(recording.views) - len(left_out),
        tuple(left_out),
        state.get("suggested_model"),
    )


def calibrate_offline(recording: Recording, model: str, time: int) -> CaptureResult:
    """Calibrate on this machine with `calibsolver`, the board taken as drawn; nothing is sent.

    Parameters
    ----------
    recording, model
        The views, and the distortion model.
    time
        Unix seconds of the calibration.

    Raises MissingPackageError without `calibsolver`, CaptureError if the views do not suffice.
    """
    try:
        import calibsolver
        from calibsolver.quality import assessment, model_selection
    except ImportError:
        raise MissingPackageError("calibrating offline needs the solver: pip install calibsolver") from None
    board = calibsolver.Board(**{**recording.board.record(), "squares": recording.board.squares})
    try:
        views = board.views([{"ids": view.ids, "points": view.points} for view in recording.views])
        fitted = calibsolver.fit(views, recording.key.img_size, model)
        choice = model_selection.suggest_model(views, recording.key.img_size)
    except (calibsolver.CalibrationError, ValueError) as error:
        raise CaptureError(
            f"the pictures determine no calibration ({error}): take more, with the board tilted"
        ) from None
    said = assessment.assess(fitted, views, choice.held_out.get(model))
    cut = tuple((recording.views[n].source, _words(why)) for n, why in sorted(fitted.cut_views.items()))
    record = {
        **fitted.record(),
        **recording.key.record(),
        "id": None,
        "calibrations": 1,
        "contributors": 1,
        "reliable": False,
        "exact_size": True,
        "calibration_time": time,
    }
    return CaptureResult(
        Calibration(record),
        len(views) - len(cut),
        cut,
        None if choice.model == model else choice.model,
        (said.level, *(reason.text for reason in said.reasons)),
    )


def _words(reason: object) -> str:
    return _REASONS.get(str(reason), str(reason))
