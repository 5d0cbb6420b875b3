"""A check of the database's calibration of a camera, on a few fresh views of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import CaptureError
from .flows import Flow
from .recording import RecordedView, Recording
from .wire import Request

if TYPE_CHECKING:
    from .calibration import Calibration

CHECK_VIEWS = 3
"""Views of a check: three, tilted differently, tell whether a calibration fits."""


@dataclass(frozen=True)
class CheckResult:
    """Result of a check.

    Attributes
    ----------
    fits
        True if the calibration fits the views.
    error, expected
        px rms of the views under it, and under their own fit.
    counted
        True if the check counts as a vote.
    votes
        Number of votes that agree, and that disagree.
    calibration
        The calibration that was checked.
    record
        All that the service answered.
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
    make: Callable[[Mapping[str, Any]], Calibration],
    consent: Mapping[str, str],
) -> Flow[CheckResult]:
    """Have the service score its calibration on the views of a recording, of which three are sent."""
    body = {**body_of(recording, CHECK_VIEWS), "distortion_model": model, **consent}
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
    """Open a session, and have the service check what the body of the request describes."""
    reply = yield Request("POST", "v1/auth")
    reply = yield Request("POST", "v1/checks", body, credential=str(reply.json["session_id"]))
    return reply.json


def body_of(recording: Recording, count: int) -> dict[str, Any]:
    """Return the members of a check that say what was seen, in `count` views at most."""
    return {**recording.key.record(), **views_of(recording, count)}


def views_of(recording: Recording, count: int) -> dict[str, Any]:
    """Return the members of a request that say what was seen: the board, and `count` views at most."""
    views = most_different(recording, count)
    return {
        "board": recording.board.record(),
        "views": [view.record() for view in views],
    }


def most_different(recording: Recording, count: int) -> Sequence[RecordedView]:
    """Return the views, at most `count`, in which the board is tilted most differently.

    Raises CaptureError if there are none.
    """
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
