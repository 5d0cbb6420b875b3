"""A view comes in: it is judged, the camera is fitted anew, and the next pose is chosen. Or a view is undone.

The view that makes the session converge ends it: the calibration is published and its consensus asked for.
The session's own document says so first. Everything after that follows from this document and can be done
again: a client that repeats a view whose answer it missed completes what a crash left undone.
"""

from __future__ import annotations

from starlette.responses import Response

import calibsolver
from calibdb import capture, http
from calibdb.schema import (
    DISTORTION_MODELS,
    EstimateDocument,
    RefitRequest,
    SessionDocument,
    ViewAnswer,
    ViewDocument,
    ViewRequest,
)
from calibdb.schema.session import Refusal
from calibdb.tokens import contributor
from calibsolver import Board, guidance
from calibsolver.capture import Capture, Estimate


def submit(call: http.Call) -> Response:
    """Answer whether the view became part of the session, and the session's state."""
    ticket = call.session(charge="views")
    view = call.json(ViewRequest)
    service = call.service
    who = contributor(service.settings.contributor_secret, call.address, ticket.token)

    def change(
        document: SessionDocument,
    ) -> tuple[SessionDocument | None, tuple[SessionDocument, Refusal | None]]:
        if capture.repeated(document, view):
            return None, (document, None)
        capture.check(document, view)
        changed, reason = judge(document, view, service.now)
        if changed is None:
            return None, (document, reason)
        if changed.estimate.converged:
            changed = capture.finished(changed, service.now, who, calibsolver.__version__)
        return changed, (changed, None)

    document, reason = service.store.sessions.update(ticket.sid, service.now, change)
    if document.finish is not None:
        publish(call, document)
    return http.answer(ViewAnswer.model_validate(capture.view_state(document, reason)))


def remove(call: http.Call) -> Response:
    """Undo: answer with the state of the session without one of its views."""
    sid = call.session(charge="views").sid
    index = call.index("index")

    def change(document: SessionDocument) -> tuple[SessionDocument | None, SessionDocument]:
        left = capture.undo(document, index)
        if left is None:
            return None, document
        rules, views = solver(document, left)
        estimate = rules.estimate(views)
        target = rules.next_target(views, estimate).to_dict()
        changed = capture.with_views(
            document, left, recorded(estimate, call.service.now), estimate.view_errors, target
        )
        return changed, changed

    document = call.service.store.sessions.update(sid, call.service.now, change)
    return http.answer(capture.state(document))


def judge(
    document: SessionDocument, view: ViewRequest, now: int
) -> tuple[SessionDocument | None, Refusal | None]:
    """Return the document with the view in it, or None and why it was refused."""
    rules, views = solver(document, document.views)
    if document.target is not None:
        target = guidance.TargetPose.from_dict(document.target)
    else:  # nobody asked where to hold the board
        target = rules.next_target(views, rules.estimate(views))
    seen = rules.board.view(view.ids, view.points)
    verdict = rules.judge(views, target, seen)
    estimate = verdict.estimate
    if not verdict.accepted or estimate is None:
        return None, verdict.reason
    following = None if estimate.converged else rules.next_target([*views, seen], estimate).to_dict()
    return capture.with_view(document, view, recorded(estimate, now), estimate.view_errors, following), None


def publish(call: http.Call, document: SessionDocument) -> None:
    """Make the calibration findable, and have every model's consensus computed."""
    store = call.service.store
    calibration = capture.calibration(document)
    store.calibrations.publish(calibration)
    store.refit.later(
        RefitRequest(
            camera=calibration.camera_key,
            img_size=calibration.img_size,
            zoom=calibration.zoom,
            models=DISTORTION_MODELS,
        )
    )


def solver(
    document: SessionDocument, views: tuple[ViewDocument, ...]
) -> tuple[Capture, list[calibsolver.View]]:
    """Return the solver's rules for this session, and its views."""
    board = Board(**document.board.model_dump())
    rules = Capture(
        board,
        document.img_size,
        model=document.distortion_model,
        guidance=document.guidance,
        target_error=document.target_error,
    )
    return rules, [board.view(view.ids, view.points) for view in views]


def recorded(estimate: Estimate, now: int) -> EstimateDocument:
    """Return the estimate as it is stored."""
    fit = estimate.calibration
    uncertainty = estimate.uncertainty
    return EstimateDocument(
        fit=fit.record() if fit else None,
        uncertainty={"rms": uncertainty.rms, "max": uncertainty.max} if uncertainty else None,
        progress=estimate.progress,
        converged=estimate.converged,
        time=now,
    )


handler = http.handler(
    http.resource("/v1/session/views", POST=submit),
    http.resource("/v1/session/views/{index}", DELETE=remove),
)
