"""Sessions of the service, and results of captures."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from .board import Board
from .calibration import Calibration, Maker
from .errors import CaptureError, ConflictError, UsageError
from .flows import Flow
from .model_choice import chosen_model
from .recording import Progress, Recording
from .wire import Request

LICENCE = "CC0-1.0"
LICENCE_VERSION = "2026-11-22"
"""Date of the terms that this version of the client refers to: `/terms/` of the site."""
_REASONS = {
    "duplicate": "the board was there already",
    "no_information": "it adds no information",
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
    used
        Number of views behind the calibration.
    left_out
        Sources of views that are not, and why.
    suggested_model
        Distortion model that explains these views better, or None.
    verdict
        Level and reasons, the one to act on first; empty if an older service states none.
    """

    calibration: Calibration
    used: int
    left_out: tuple[tuple[str, str], ...] = ()
    suggested_model: str | None = None
    verdict: tuple[str, ...] = ()

    def board_sentence(self, square_mm: float | None = None) -> str | None:
        """Return a sentence on the bend and the print of the board; None if it was taken as drawn.

        Lengths are in millimetres if `square_mm`, the side of a square, is given.
        """
        recording, shape = self.calibration.recording, self.calibration.record.get("board_shape")
        if recording is None:
            return Board().shape_sentence(shape, None)
        return recording.board.shape_sentence(shape, square_mm)


def start(
    recording: Recording, model: str, capture: str, consent: Mapping[str, str]
) -> Flow[tuple[str, Mapping[str, Any]]]:
    """Open a session, and return its id and state.

    `capture`: ``live`` or ``recorded``; `consent`: as of `consent_of`.
    """
    reply = yield Request("POST", "v1/auth")
    session = str(reply.json["session_id"])
    body = {
        **recording.key.record(),
        "distortion_model": model,
        "board": recording.board.record(),
        "capture": capture,
        **consent,
    }
    reply = yield Request("POST", "v1/session", body, credential=session)
    return session, reply.json


def consent_of(licence: str | None, mode_name: str | None = None) -> dict[str, str]:
    """Return the members by which a contributor agrees to a licence, and names the camera's mode.

    Raises UsageError for a licence that the database does not have.
    """
    members = {"mode_name": mode_name} if mode_name else {}
    if licence is None:
        return members
    if licence != LICENCE:
        raise UsageError(f"calibrations are given away under {LICENCE}, or not at all, not {licence!r}")
    return members | {"licence": LICENCE, "licence_version": LICENCE_VERSION}


def submit(
    recording: Recording,
    model: str,
    make: Maker,
    progress: Progress | None = None,
    consent: Mapping[str, str] | None = None,
) -> Flow[CaptureResult]:
    """Send the corners of a recording, and end the session with those that agree.

    Views that contradict the ones before them are offered again at the end: the first may be the wrong ones.

    Raises CaptureError if they do not suffice.
    """
    if recording.board.kind.endswith("circles"):
        raise UsageError("the service takes no grids of circles: calibrate with --offline")
    model, better = chosen_model(recording, model)
    session, _ = yield from start(recording, model, "recorded", consent or {})
    accepted: list[str] = []
    refused: dict[str, str] = {}
    waiting = list(recording.views)
    while waiting:
        count, contradicting = len(accepted), []
        while waiting:
            body = {"index": len(accepted), "views": [view.record() for view in waiting]}
            reply = yield Request("POST", "v1/session/batch", body, credential=session)
            results = reply.json["results"]
            for view, result in zip(waiting, results, strict=False):
                if result["accepted"]:
                    accepted.append(view.source)
                    refused.pop(view.source, None)
                else:
                    refused[view.source] = refusal(result["reason"])
                    contradicting += [view] if result["reason"] == "outlier" else []
            waiting = waiting[len(results) :]
            if progress:
                progress(len(accepted) + len(refused), len(recording.views))
        waiting = contradicting if len(accepted) > count else []
    left_out = list(refused.items())
    try:
        reply = yield Request("POST", "v1/session/finish", credential=session)
    except ConflictError as error:
        raise CaptureError(f"{error} Take more pictures, with the board tilted in several ways") from None
    state = reply.json
    for source, view_state in zip(accepted, state.get("views", []), strict=False):
        if aside := view_state.get("set_aside"):
            left_out.append((source, refusal(aside.get("reason"))))
    if not isinstance(state.get("calibration"), dict):
        raise CaptureError("the views determine no calibration: take more pictures, with the board tilted")
    return result_of(state, make, len(recording.views) - len(left_out), tuple(left_out), better)


def result_of(
    state: Mapping[str, Any],
    make: Maker,
    used: int,
    left_out: tuple[tuple[str, str], ...],
    suggested: str | None,
) -> CaptureResult:
    """Return the result of a session that has ended with a calibration."""
    record, verdict = state["calibration"], state.get("verdict")
    words: tuple[str, ...] = ()
    if isinstance(verdict, Mapping):  # older services state none
        words = str(verdict["level"]), *(str(reason["text"]) for reason in verdict["reasons"])
    calibration = make({**record, "id": state.get("calibration_id") or record.get("id")})
    return CaptureResult(calibration, used, left_out, suggested, words)


def refusal(reason: object) -> str:
    """Return the words of a reason for which a view does not count."""
    return _REASONS.get(str(reason), str(reason))
