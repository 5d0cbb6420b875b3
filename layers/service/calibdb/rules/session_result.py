"""Results of a session: its state in the API, its end and its calibration."""

import hashlib
from collections.abc import Sequence
from typing import Any, Literal

from pydantic import JsonValue

from calibdb.schema import (
    BatchAnswer,
    CalibrationDocument,
    Finish,
    SessionDocument,
    SessionState,
    ViewAnswer,
    ViewDocument,
    ViewState,
)
from calibdb.schema.documents import CaptureDocument
from calibdb.schema.session import BatchResult, Hint, Refusal

_DAY_S = 86_400


def with_finish(
    document: SessionDocument,
    now: int,
    contributor: str,
    solver: str,
    report: dict[str, JsonValue] | None = None,
    source: str | None = None,
) -> SessionDocument:
    """End the session: fix everything that publishing it needs."""
    finish = Finish(
        calibration_id=calibration_id(document),
        time=now,
        contributor=contributor,
        source=source,
        solver=solver,
        report=report,
    )
    ended = {"finish": finish, "target": None, "skipped": (), "unreached": (), "doubted": ()}
    return document.model_copy(update=ended)


def calibration_id(document: SessionDocument) -> str:
    """Id of the calibration to which a session leads."""
    return f"{document.camera_key}-{calibration_name(document.session, document.first_version)}"


def calibration_name(sid: str, first_version: int) -> str:
    """Second part of a calibration id; the session cannot be derived from it.

    Ids are public, so they contain only the day of the session's start.
    """
    day = int(sid[:8], 16) // _DAY_S * _DAY_S
    return f"{day:08x}{hashlib.sha256(f'{sid}/{first_version}'.encode()).hexdigest()[:12]}"


def to_calibration(document: SessionDocument) -> CalibrationDocument:
    """Calibration of a converged session."""
    finish, fit = document.finish, document.estimate.fit
    if finish is None or fit is None:
        raise ValueError("the session has not converged")
    capture = {name: getattr(document, name) for name in CaptureDocument.model_fields}
    by_whom = {"contributor": finish.contributor, "source": finish.source}
    return CalibrationDocument(
        **{**capture, **by_whom, "camera_key": document.current_key},
        id=finish.calibration_id,
        views=tuple(view for view in document.views if view.set_aside is None),
        set_aside=tuple(view for view in document.views if view.set_aside is not None),
        fits={document.distortion_model: fit},
        report=finish.report,
        solver=finish.solver,
        time=finish.time,
    )


def state(document: SessionDocument) -> SessionState:
    """State of a session in the API."""
    return SessionState(**_members(document))


def view_answer(document: SessionDocument, reason: Refusal | None, hint: Hint | None = None) -> ViewAnswer:
    """State after a view and, after a refusal, its reason and a remedy."""
    members = {**_members(document), "accepted": reason is None, "reason": reason, "hint": hint}
    return ViewAnswer.model_validate(members)


def batch_answer(document: SessionDocument, results: Sequence[BatchResult]) -> BatchAnswer:
    """State after a batch, and the result of each judged view."""
    return BatchAnswer.model_validate({**_members(document), "results": tuple(results)})


def accepted_result(view: ViewDocument) -> BatchResult:
    """Result of an accepted view."""
    return BatchResult(accepted=True, index=view.index, reason=None, error=view.stated)


def _members(document: SessionDocument) -> dict[str, Any]:
    finish, estimate = document.finish, document.estimate
    status: Literal["capturing", "converged"] = "capturing" if finish is None else "converged"
    calibration_id = finish.calibration_id if finish else None
    time = finish.time if finish else estimate.time
    fit = estimate.fit and document.calibrated(estimate.fit, calibration_id, time)
    return {
        **dict(document),  # which has more members
        "status": status,
        "views": tuple(
            ViewState(
                index=v.index, points=len(v.ids), rms=v.rms, set_aside=v.set_aside, on_target=v.on_target
            )
            for v in document.views
        ),
        "progress": estimate.progress,
        "uncertainty": estimate.uncertainty,
        "systematic": estimate.fit and estimate.fit.systematic,
        "board_shape": estimate.fit and estimate.fit.board_shape,
        "calibration": fit,
        "calibration_id": calibration_id,
        "end": estimate.end if finish else None,
        "verdict": finish.report.get("verdict") if finish and finish.report else None,
        "advice": estimate.advice,
        "suggested_model": estimate.suggested_model,
    }
