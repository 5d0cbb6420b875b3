"""Checks of a calibration on a few fresh views."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from calibsolver.consensus.comparison import Comparison as Comparison

from .errors import CaptureError, UsageError
from .flows import Flow
from .recording import RecordedView, Recording
from .wire import Request

if TYPE_CHECKING:
    from .calibration import Calibration, Maker

CHECK_VIEWS = 3
"""Views of a check: three, tilted differently, tell whether a calibration fits."""

MAX_SENT_VIEWS = 5


@dataclass(frozen=True)
class CheckResult:
    """Result of a check.

    `fits`: the calibration fits the views. `error` and `expected`: px rms of the views under it, and under
    their own fit. `votes`: numbers that agree and disagree; `counted`: this check is one of them. `record`:
    all that the service answered.
    """

    fits: bool
    error: float
    expected: float
    counted: bool
    votes: tuple[int, int]
    calibration: Calibration
    record: Mapping[str, Any]


def check(
    recording: Recording,
    model: str,
    make: Maker,
    consent: Mapping[str, str],
) -> Flow[CheckResult]:
    """Have the service score its calibration on the views of a recording, of which three are sent."""
    body = {**_body_of(recording, CHECK_VIEWS), "distortion_model": model, **consent}
    record = yield from ask(body)
    return CheckResult(
        record["fits"] == "fits",
        float(record["error"]),
        float(record["expected"]),
        bool(record["counted"]),
        (int(record["votes"]["agree"]), int(record["votes"]["disagree"])),
        make(record["calibration"]),
        record,
    )


def ask(body: Mapping[str, Any]) -> Flow[Mapping[str, Any]]:
    """Have the service check, in a new session, what the body of the request describes."""
    reply = yield Request("POST", "v1/auth")
    reply = yield Request("POST", "v1/checks", body, credential=str(reply.json["session_id"]))
    return reply.json


def _body_of(recording: Recording, count: int) -> dict[str, Any]:
    return {**recording.key.record(), **views_of(recording, count)}


def views_of(recording: Recording, count: int) -> dict[str, Any]:
    """Return the board, and `count` views at most, as the members of a request."""
    views = _most_different(recording, count)
    return {
        "board": recording.board.record(),
        "views": [view.record() for view in views],
    }


def _most_different(recording: Recording, count: int) -> Sequence[RecordedView]:
    """Return the views, at most `count`, in which the board is tilted most differently."""
    from .capture.outline import difference, outline_of

    outlines = [outline_of(recording.board, view.ids, view.points) for view in recording.views]
    shapes = {i: outline for i, outline in enumerate(outlines) if outline is not None}
    if not shapes:
        raise CaptureError("no picture shows the board: show it, tilted, and try again")
    chosen = [next(iter(shapes))]
    while len(chosen) < min(count, len(shapes)):
        left = [i for i in shapes if i not in chosen]
        distance = [min(difference(shapes[i], shapes[k]) for k in chosen) for i in left]
        chosen.append(left[int(np.argmax(distance))])
    return [recording.views[i] for i in sorted(chosen)]


def compare(recording: Recording, calibration: Calibration) -> Comparison:
    """Compare a calibration with what a fit of the views of a recording gives.

    Raises UsageError if the pictures have another size, CaptureError if the views do not suffice.
    """
    import calibsolver
    from calibsolver.consensus import comparison

    _require_size(recording, calibration)
    try:
        views = recording.observations()
        return comparison.compare(calibration.lens, views)
    except (calibsolver.CalibrationError, ValueError) as why:
        raise CaptureError(f"the views do not suffice for a check: {why}") from None


def compare_by_service(recording: Recording, calibration: Calibration) -> Flow[Comparison]:
    """Have the service compare; at most five views are sent, nothing is stored, and no vote counts.

    Raises UsageError if the pictures have another size.
    """
    _require_size(recording, calibration)
    names = ("img_size", "camera_matrix", "distortion_coefficients", "distortion_model")
    record = {name: calibration.record[name] for name in names}
    body = {**_body_of(recording, MAX_SENT_VIEWS), "calibration": record}
    return _comparison((yield from ask(body)))


def _comparison(record: Mapping[str, Any]) -> Comparison:
    def length(name: str) -> float:
        return math.inf if record[name] is None else float(record[name])

    return Comparison(
        record["fits"] == "fits",
        length("error"),
        length("expected"),
        length("drift"),
        length("drift_uncertainty"),
        int(record["views"]),
    )


def _require_size(recording: Recording, calibration: Calibration) -> None:
    (w, h), (width, height) = recording.key.img_size, calibration.img_size
    if (w, h) != (width, height):
        raise UsageError(f"the pictures have {w} x {h} px, the calibration is of {width} x {height}")
