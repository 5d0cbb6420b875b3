"""Submit: decide on a view, fit the camera anew and choose the next pose; undo a view; finish a recording.

The view that makes a live session converge ends it; a recorded session, whose views are all there already, is
ended by its client. Then the calibration is published and its consensus asked for. The session's own document
says so first. Everything after that follows from this document and is idempotent:
a client that repeats a view whose answer it missed completes what a crash left undone.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace

from starlette.responses import Response

import calibsolver
from calibdb.access.tokens import contributor, source
from calibdb.errors import ConflictError, InvalidError
from calibdb.http import application, metrics
from calibdb.rules import rig_rules, session_result, session_rules
from calibdb.rules.session_state import accepted_result, batch_answer, state, view_answer
from calibdb.schema import BatchRequest, SessionDocument, ViewDocument, ViewRequest
from calibdb.schema.session import BatchResult, Hint, LicenceRequest, Refusal
from calibdb.store import Store, endings
from calibsolver import CalibrationError, Camera, DeadlineError, View, deadline, guidance
from calibsolver.capture import Capture, Estimate, Exclusion, History, ViewDecision, stored

MIN_BATCH_S = 1.0
"""Time left of a request, s, below which a batch begins no further view: the advice needs it."""
BatchOutcome = tuple[SessionDocument, list[BatchResult]]


def submit(call: application.Call) -> Response:
    """Answer whether the view became part of the session, and the session's state."""
    ticket = call.session(charge="views")
    request = call.json(ViewRequest)
    service = call.service
    secret = service.settings.contributor_secret
    who = contributor(secret, call.address, ticket.token)
    where = source(secret, call.address)

    def change(document: SessionDocument) -> tuple[SessionDocument | None, tuple[SessionDocument, Judgement]]:
        view = rig_rules.sent_view(document, request)
        if is_replay(service.store, document, view):
            return None, (document, Judgement())
        session_rules.validate_view(document, view)
        begun = service.clock()
        judged = Course(document, service.now, who, where).judge(view)
        measure(begun, service.clock(), judged)
        if judged.reason is not None and (judged.document is None or judged.document.finish is None):
            return judged.document, (document, judged)  # nothing changes that anyone could see
        return judged.document, (judged.document or document, judged)

    with in_time(call):
        document, judged = service.store.sessions.update(ticket.sid, service.now, change)
    if document.finish is not None:
        endings.publish(service.store, document)
    return application.json_response(view_answer(document, judged.reason, judged.hint))


def submit_batch(call: application.Call) -> Response:
    """Judge several views of a recording in their order; respond with their results and the session's state.

    Views that the request has no time left to judge have no result.
    """
    ticket = call.session(charge="views")
    request = call.json(BatchRequest, depth=2)
    service = call.service

    def change(document: SessionDocument) -> tuple[SessionDocument | None, BatchOutcome]:
        session_rules.require_recorded(document)
        replayed = session_rules.replayed_views(document, request.index, request.views)
        if document.finish is not None and None in replayed:
            raise session_rules.already_converged()
        session_rules.validate_batch(document, request.views, replayed)
        course = Course(document, service.now, explains=False)
        results: list[BatchResult] = []
        for view, known in zip(request.views, replayed, strict=True):
            if known is not None:
                results.append(accepted_result(known))
                continue
            if results and call.seconds_left() < MIN_BATCH_S:
                break
            begun = service.clock()
            sent = ViewDocument(index=course.document.next_index, ids=view.ids, points=view.points)
            try:
                judged = course.judge(sent)
            except DeadlineError:
                if not results:
                    raise
                break
            except CalibrationError:
                judged = Judgement(reason="degenerate")
            measure(begun, service.clock(), judged)
            if judged.reason is None:
                results.append(accepted_result(course.document.views[-1]))
            else:
                results.append(BatchResult(accepted=False, index=None, reason=judged.reason, error=None))
        if len(results) == len(request.views):
            course.explain()
        changed = course.document
        return (None if changed is document else changed), (changed, results)

    with in_time(call):
        document, results = service.store.sessions.update(ticket.sid, service.now, change)
    return application.json_response(batch_answer(document, results))


def is_replay(store: Store, document: SessionDocument, view: ViewDocument) -> bool:
    """Tell whether the session has the view; False when it may be added."""
    if document.rig is None:
        return session_rules.is_idempotent_replay(document, view)
    if rig_rules.is_replay(document, view):
        return True
    rig_rules.require_moment(store.rigs.find(document.rig.id), document, view)
    return False


def remove(call: application.Call) -> Response:
    """Undo: answer with the state of the session without one of its views."""
    sid = call.session(charge="views").sid
    index = call.index("index")

    def change(document: SessionDocument) -> tuple[SessionDocument | None, SessionDocument]:
        if document.rig is not None:
            raise rig_rules.in_rig()
        left = session_rules.without_view(document, index)
        if left is None:
            return None, document
        rules, views, excluded = stored.parse(document.model_copy(update={"views": left}).model_dump())
        estimate = rules.reconcile(views, excluded)
        unreached = stored.parse_targets(document.unreached)
        target = rules.next_target(views, estimate, unreached=unreached).to_record()
        known = session_rules.estimate_document(stored.estimate_record(estimate), call.service.now)
        changed = session_rules.with_views(document, left, known, stored.view_statuses(estimate), target)
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
        if document.rig is not None:
            raise rig_rules.in_rig()
        session_rules.require_finishable(document)
        outcome = stored.finish(document.model_dump())
        known = session_rules.estimate_document(outcome["estimate"], service.now)
        changed = session_rules.with_estimate(document, known, outcome["statuses"])
        version, described = calibsolver.FIT_VERSION, outcome["report"]
        ended = session_result.with_finish(changed, service.now, who, version, described, where)
        return ended, ended

    with in_time(call):
        document = service.store.sessions.update(ticket.sid, service.now, change)
    endings.publish(service.store, document)
    return application.json_response(state(document))


def license_views(call: application.Call) -> Response:
    """Add the contributor's licence to a session and to what it published; answer with its state."""
    sid = call.session(charge="views").sid
    request = call.json(LicenceRequest)
    store = call.service.store

    def change(document: SessionDocument) -> tuple[SessionDocument | None, SessionDocument]:
        if document.licence is not None:
            return None, document
        changed = document.model_copy(update=request.consent)
        return changed, changed

    document = store.sessions.update(sid, call.service.now, change)
    if document.finish is not None:
        endings.publish(store, document)  # where a crash left that undone
        store.calibrations.license(document.finish.calibration_id, request)
    return application.json_response(state(document))


@dataclass(frozen=True)
class Judgement:
    """Result of a view: the session document to store if it changes, and the reason of a refusal."""

    document: SessionDocument | None = None
    reason: Refusal | None = None
    hint: Hint | None = None


class Course:
    """Course of one session while views are offered to it.

    Parameters
    ----------
    document
        The session. The attribute has the session with all views accepted since.
    now
        Unix seconds.
    who, where
        Keyed hashes of the contributor and of their source, for a live session, which a view may end.
    explains
        False: views are judged without advice, which `explain` adds.
    """

    def __init__(
        self, document: SessionDocument, now: int, who: str = "", where: str = "", *, explains: bool = True
    ) -> None:
        self.document = document
        self._now, self._who, self._where, self._explains = now, who, where, explains
        self._estimate: Estimate | None = None
        self._rules, self._views, self._excluded = stored.parse(document.model_dump())

    def judge(self, view: ViewDocument) -> Judgement:
        """Judge the view. One that contradicts the others is kept as a witness even where it is refused."""
        document, rules, views, excluded = self.document, self._rules, self._views, self._excluded
        target = None if rules.recorded else open_target(document, rules, views, excluded)
        seen = rules.board.view(view.ids, view.points)
        quarantined = rules.board.views([known.model_dump() for known in document.doubted])
        decision = rules.judge(
            views, target, seen, excluded, quarantined, history_of(document), explain=self._explains
        )
        if decision.seed_rejected:
            document, rules = session_rules.without_seed(document), rules.without_seed()
        estimate = decision.estimate
        if not decision.accepted or estimate is None:
            hint = Hint(code=decision.hint.code, text=decision.hint.text) if decision.hint else None
            refused = refused_document(document, view, decision)
            if refused is not None and history_of(refused).is_exhausted(len(views) - len(excluded)):
                estimate = rules.estimate(views, excluded).with_cause(views)
                estimate = replace(estimate, progress=1.0, end="nothing_new")
                refused = end_without_view(refused, estimate, views, self._now, self._who, self._where)
            self.document, self._rules = refused or self.document, rules
            return Judgement(refused, decision.reason, hint)
        everything = [*views, seen]
        following = None
        if not (estimate.converged or rules.recorded):
            unreached = stored.parse_targets((*document.unreached, *document.skipped))
            following = rules.next_target(everything, estimate, unreached=unreached).to_record()
        known = session_rules.estimate_document(stored.estimate_record(estimate), self._now)
        changed = session_rules.with_view(
            document, view, known, stored.view_statuses(estimate), following, decision.on_target
        )
        if estimate.converged:
            changed = end(changed, estimate, everything, self._now, self._who, self._where)
        self.document, self._rules = changed, rules
        self._views, self._excluded, self._estimate = everything, dict(estimate.excluded), estimate
        return Judgement(changed)

    def explain(self) -> None:
        """Add the advice about the views accepted, unless the time is up."""
        if self._estimate is not None:
            with suppress(DeadlineError):
                estimate = self._rules.explain(self._views, self._estimate)
                known = session_rules.estimate_document(stored.estimate_record(estimate), self._now)
                self.document = session_rules.with_advice(self.document, known)


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
    indices = [known.index for known in document.views if known.set_aside is None]
    outcome = stored.end(estimate, views, indices)
    if outcome is None:
        return document
    ended = session_rules.with_fit(document, outcome.fit)
    return session_result.with_finish(ended, now, who, calibsolver.FIT_VERSION, outcome.report, where)


def end_without_view(
    document: SessionDocument, estimate: Estimate, views: Sequence[View], now: int, who: str, where: str
) -> SessionDocument:
    """Return the document of a session that ends with the views it has."""
    known = session_rules.estimate_document(stored.estimate_record(estimate), now)
    changed = session_rules.with_estimate(document, known, stored.view_statuses(estimate))
    return end(changed, estimate, views, now, who, where)


def history_of(document: SessionDocument) -> History:
    """Return the course of a session so far."""
    views = document.views
    return History(
        tuple(v.stated for v in views), tuple(bool(v.on_target) for v in views), document.duplicates
    )


def refused_document(
    document: SessionDocument, view: ViewDocument, decision: ViewDecision
) -> SessionDocument | None:
    """Return the document to store after a refusal; None where nothing changes."""
    if decision.quarantine:
        return session_rules.with_quarantined(document, view)
    if decision.reason == "duplicate":
        return session_rules.with_duplicate(document)
    return document if decision.seed_rejected else None


def measure(begun: float, ended: float, judged: Judgement) -> None:
    """Have the judgement counted; `begun`, `ended`: unix seconds."""
    counted: dict[str, float] = {"Views": 1, "FitTime": round((ended - begun) * 1e3, 1)}
    if judged.reason is not None:
        counted["Refusals"] = 1
    elif judged.document is not None and judged.document.finish is not None:
        counted |= {"Calibrations": 1, "ViewsPerSession": len(judged.document.views)}
    metrics.count(ended, reason=judged.reason, **counted)


handler = application.handler(
    application.route("/v1/session/views", POST=submit),
    application.route("/v1/session/batch", POST=submit_batch),
    application.route("/v1/session/views/{index}", DELETE=remove),
    application.route("/v1/session/finish", POST=finish),
    application.route("/v1/session/licence", POST=license_views),
)
