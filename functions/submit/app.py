"""Submit: decide on a view, fit the camera anew and choose the next pose; undo a view; finish a recording.

The view that makes a live session converge ends it; a recorded session, whose views are all there already, is
ended by its client. Then the calibration is published and its consensus asked for. The session's own document
says so first. Everything after that follows from this document and is idempotent:
a client that repeats a view whose answer it missed completes what a crash left undone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

from pydantic import JsonValue
from starlette.responses import Response

import calibsolver
from calibdb.access.tokens import contributor, source
from calibdb.errors import ConflictError, InvalidError
from calibdb.http import application, metrics
from calibdb.rules import session_rules
from calibdb.rules.session_state import state, view_answer
from calibdb.schema import (
    DISTORTION_MODELS,
    EstimateDocument,
    FitRecord,
    RefitRequest,
    SessionDocument,
    ViewRequest,
)
from calibdb.schema.session import Advice, Hint, Refusal, SetAside
from calibsolver import CalibrationError, Camera, DeadlineError, View, deadline, guidance
from calibsolver.capture import Capture, Estimate, Exclusion, ViewDecision, exclusions
from calibsolver.quality import report
from calibsolver.quality.board_flatness import shaped_fit


def submit(call: application.Call) -> Response:
    """Answer whether the view became part of the session, and the session's state."""
    ticket = call.session(charge="views")
    view = call.json(ViewRequest)
    service = call.service
    secret = service.settings.contributor_secret
    who = contributor(secret, call.address, ticket.token)
    where = source(secret, call.address)

    def change(document: SessionDocument) -> tuple[SessionDocument | None, tuple[SessionDocument, Judged]]:
        if session_rules.is_idempotent_replay(document, view):
            return None, (document, Judged())
        session_rules.validate_view(document, view)
        begun = service.clock()
        judged = judge(document, view, service.now, who, where)
        measure(begun, service.clock(), judged)
        if judged.reason is not None:  # nothing changes that anyone could see
            return judged.document, (document, judged)
        return judged.document, (judged.document or document, judged)

    with in_time(call):
        document, judged = service.store.sessions.update(ticket.sid, service.now, change)
    if document.finish is not None:
        publish(call, document)
    return application.json_response(view_answer(document, judged.reason, judged.hint))


def remove(call: application.Call) -> Response:
    """Undo: answer with the state of the session without one of its views."""
    sid = call.session(charge="views").sid
    index = call.index("index")

    def change(document: SessionDocument) -> tuple[SessionDocument | None, SessionDocument]:
        left = session_rules.without_view(document, index)
        if left is None:
            return None, document
        rules, views, excluded = solver_values(document.model_copy(update={"views": left}))
        estimate = rules.reconcile(views, excluded)
        target = rules.next_target(views, estimate, unreached=targets(document.unreached)).to_record()
        now = call.service.now
        changed = session_rules.with_views(
            document, left, to_estimate_document(estimate, now), view_statuses(estimate), target
        )
        return changed, changed

    with in_time(call):
        document = call.service.store.sessions.update(sid, call.service.now, change)
    return application.json_response(state(document))


@contextmanager
def in_time(call: application.Call) -> Iterator[None]:
    """Compute within the call's time; raises ConflictError or UnavailableError where that is too short.

    Raises InvalidError where the corners leave the camera undetermined.
    """
    try:
        with deadline.limit(call.seconds_left):
            yield
    except CalibrationError as error:
        raise InvalidError.field("points", error.message) from error
    except DeadlineError as error:
        raise call.out_of_time(
            ConflictError(
                "These corners take longer to compute than a request may; send fewer of them in each view.",
                kind="too-slow",
            )
        ) from error


def finish(call: application.Call) -> Response:
    """End a session with the views that agree, however accurate they are, and answer with its state."""
    ticket = call.session(charge="views")
    service = call.service
    secret = service.settings.contributor_secret
    who = contributor(secret, call.address, ticket.token)
    where = source(secret, call.address)

    def change(document: SessionDocument) -> tuple[SessionDocument | None, SessionDocument]:
        if document.finish is not None:
            return None, document
        session_rules.require_finishable(document)
        rules, views, excluded = solver_values(document)
        known = rules.estimate(views, excluded).with_cause(views)
        estimate = replace(known, progress=1.0, converged=True)
        changed = session_rules.with_estimate(
            document, to_estimate_document(estimate, service.now), view_statuses(estimate)
        )
        ended = end(changed, estimate, views, service.now, who, where)
        return ended, ended

    with in_time(call):
        document = service.store.sessions.update(ticket.sid, service.now, change)
    publish(call, document)
    return application.json_response(state(document))


@dataclass(frozen=True)
class Judged:
    """Result of a view: the session document to store if it changes, and the reason of a refusal."""

    document: SessionDocument | None = None
    reason: Refusal | None = None
    hint: Hint | None = None


def judge(document: SessionDocument, view: ViewRequest, now: int, who: str, where: str) -> Judged:
    """Judge the view. One that contradicts the others is kept as a witness even where it is refused."""
    rules, views, excluded = solver_values(document)
    target = None if document.capture == "recorded" else open_target(document, rules, views, excluded)
    seen = rules.board.view(view.ids, view.points)
    quarantined = rules.board.views([known.model_dump() for known in document.doubted])
    decision = rules.judge(views, target, seen, excluded, quarantined)
    if decision.seed_rejected:
        document, rules = session_rules.without_seed(document), rules.without_seed()
    estimate = decision.estimate
    if not decision.accepted or estimate is None:
        hint = Hint(code=decision.hint.code, text=decision.hint.text) if decision.hint else None
        return Judged(refused_document(document, view, decision), decision.reason, hint)
    everything = [*views, seen]
    following = None
    if not estimate.converged and document.capture == "live":
        unreached = targets((*document.unreached, *document.skipped))
        following = rules.next_target(everything, estimate, unreached=unreached).to_record()
    changed = session_rules.with_view(
        document, view, to_estimate_document(estimate, now), view_statuses(estimate), following
    )
    if estimate.converged:
        changed = end(changed, estimate, everything, now, who, where)
    return Judged(changed)


def open_target(
    document: SessionDocument, rules: Capture, views: Sequence[View], excluded: dict[int, Exclusion]
) -> guidance.TargetPose:
    """Return the session's open target, chosen now if nobody asked where to hold the board."""
    if document.target is not None:
        target = guidance.TargetPose.from_dict(document.target)
        fit = document.estimate.fit
        active = [view for i, view in enumerate(views) if i not in excluded]
        camera = Camera.from_record(fit.model_dump()) if fit else rules.camera(None)
        return rules.redraw(target, active, camera)
    return rules.next_target(views, rules.estimate(views, excluded))


def end(
    document: SessionDocument, estimate: Estimate, views: Sequence[View], now: int, who: str, where: str
) -> SessionDocument:
    """Return the document of a session that ends with this estimate of its views."""
    if estimate.calibration is None:
        return document
    indices = [known.index for known in document.views if known.set_aside is None]
    used = [one for i, one in enumerate(views) if i not in estimate.excluded]
    board = shaped_fit(estimate.calibration, used)
    if board.used and board.shape is not None:
        used = [board.shape.apply(view) for view in used]
        fit = FitRecord.model_validate(board.calibration.record())
        known = document.estimate.model_copy(update={"fit": fit})
        document = document.model_copy(update={"estimate": known})
    described = report.describe(board.calibration, used, indices, board=board)
    return session_rules.with_finish(document, now, who, calibsolver.FIT_VERSION, described, where)


def refused_document(
    document: SessionDocument, view: ViewRequest, decision: ViewDecision
) -> SessionDocument | None:
    """Return the document to store after a refusal; None where nothing changes."""
    if decision.quarantine:
        return session_rules.with_quarantined(document, view)
    return document if decision.seed_rejected else None


def measure(begun: float, ended: float, judged: Judged) -> None:
    """Have the judgement counted; `begun`, `ended`: unix seconds."""
    counted: dict[str, float] = {"Views": 1, "FitTime": round((ended - begun) * 1e3, 1)}
    if judged.reason is not None:
        counted["Refusals"] = 1
    elif judged.document is not None and judged.document.finish is not None:
        counted |= {"Calibrations": 1, "ViewsPerSession": len(judged.document.views)}
    metrics.count(ended, reason=judged.reason, **counted)


def publish(call: application.Call, document: SessionDocument) -> None:
    """Make the calibration findable, and have every model's consensus computed."""
    store = call.service.store
    calibration = session_rules.to_calibration(document)
    store.calibrations.publish(calibration)
    store.refit.later(
        RefitRequest(
            camera=calibration.camera_key,
            img_size=calibration.img_size,
            zoom=calibration.zoom,
            models=DISTORTION_MODELS,
        )
    )


def solver_values(document: SessionDocument) -> tuple[Capture, list[View], dict[int, Exclusion]]:
    """Convert a session to the solver's values: its rules, its views, and those of them that are excluded."""
    record = document.model_dump()
    rules = Capture.from_record(record)
    return rules, rules.board.views(record["views"]), exclusions(record["views"])


def targets(stored: Sequence[dict[str, JsonValue]]) -> tuple[guidance.TargetPose, ...]:
    """Return stored targets as the solver knows them."""
    return tuple(guidance.TargetPose.from_dict(target) for target in stored)


def view_statuses(estimate: Estimate) -> list[session_rules.ViewStatus]:
    """List each view's error, and why it is set aside if it is."""
    reasons = [estimate.excluded.get(i) for i in range(len(estimate.view_errors))]
    stored = [SetAside(reason=r.reason, detail=r.detail) if r else None for r in reasons]
    return list(zip(estimate.view_errors, stored, strict=True))


def to_estimate_document(estimate: Estimate, now: int) -> EstimateDocument:
    """Return the estimate as it is stored."""
    fit = estimate.calibration
    uncertainty = estimate.uncertainty
    return EstimateDocument(
        fit=fit.record() if fit else None,
        uncertainty={"rms": uncertainty.rms, "max": uncertainty.max} if uncertainty else None,
        progress=estimate.progress,
        converged=estimate.converged,
        advice=tuple(Advice(code=advice.code, text=advice.text) for advice in estimate.advice),
        suggested_model=estimate.suggested_model,
        time=now,
    )


handler = application.handler(
    application.route("/v1/session/views", POST=submit),
    application.route("/v1/session/views/{index}", DELETE=remove),
    application.route("/v1/session/finish", POST=finish),
)
