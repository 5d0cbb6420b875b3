"""Session state as its owner sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal

from calibdb.schema import (
    BatchAnswer,
    Calibration,
    SessionDocument,
    SessionState,
    ViewAnswer,
    ViewDocument,
    ViewState,
)
from calibdb.schema.session import BatchResult, Hint, Refusal


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
    fit = estimate.fit and Calibration.of(
        estimate.fit,
        id=calibration_id,
        camera=document.camera,
        platform=document.platform,
        zoom=document.zoom,
        calibration_time=finish.time if finish else estimate.time,
    )
    return {
        **dict(document),  # of which a state has what it shares
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
