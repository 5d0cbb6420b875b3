"""Course of a session: views are judged, undone, and lead to its end."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any, Literal

from pydantic import JsonValue

from calibdb.compute.values import board_of, camera_of, in_time, naming, views_of
from calibdb.errors import ConflictError
from calibdb.http import metrics
from calibdb.http.call import Call
from calibdb.rules import rig_rules, session_result, session_rules
from calibdb.rules.session_result import accepted_result
from calibdb.schema import BatchRequest, EstimateDocument, FitRecord, SessionDocument, ViewDocument
from calibdb.schema.session import BatchResult, Hint, Refusal, SetAside
from calibsolver import FIT_VERSION, CalibrationError, Camera, DeadlineError, View
from calibsolver.capture import Capture, Estimate, Exclusion, History, ViewDecision
from calibsolver.fitting.coverage import Coverage, record_covered, uncertainty_members
from calibsolver.guidance import TargetPose

_MIN_BATCH_S = 1.0  # left for the advice


@dataclass(frozen=True)
class Session:
    """A session as the solver's values."""

    rules: Capture
    views: list[View]
    excluded: dict[int, Exclusion]

    @classmethod
    def of(cls, document: SessionDocument) -> Session:
        """Convert a document."""
        rules = Capture(
            board_of(document.board),
            document.img_size,
            model=document.distortion_model,
            guidance=document.guidance,
            target_error=document.target_error,
            seed=None if document.prior is None else camera_of(document.prior),
            recorded=document.capture == "recorded" or document.rig is not None,
        )
        excluded = {
            i: Exclusion.from_record(view.set_aside.model_dump())
            for i, view in enumerate(document.views)
            if view.set_aside is not None
        }
        return cls(rules, views_of(rules.board, document.views), excluded)

    def estimate(self) -> Estimate:
        """Estimate the camera from the views."""
        return self.rules.estimate(self.views, self.excluded)


def current_camera(document: SessionDocument, rules: Capture) -> Camera:
    """Camera of the session's fit, or the initial one."""
    fit = document.estimate.fit
    return rules.camera(None) if fit is None else camera_of(fit)


def target_poses(records: Sequence[Mapping[str, JsonValue]]) -> tuple[TargetPose, ...]:
    """Read stored targets."""
    return tuple(map(TargetPose.from_dict, records))


def _history(document: SessionDocument) -> History:
    stated = tuple(view.stated for view in document.views)
    return History(stated, tuple(bool(view.on_target) for view in document.views), document.duplicates)


@contextmanager
def computing_views(call: Call) -> Iterator[None]:
    """Limit the time; raises ConflictError, UnavailableError, or InvalidError for a degenerate view."""
    slow = "These corners take longer to compute than a request may; send fewer of them in each view."
    with naming("points"), in_time(call, ConflictError(slow, kind="too-slow")):
        yield


@dataclass(frozen=True)
class Judgement:
    """Result of a view: the changed session document, and the reason of a refusal."""

    document: SessionDocument | None = None
    reason: Refusal | None = None
    hint: Hint | None = None
    took_ms: float | None = None
    """None of a view that was judged before."""

    def shown(self, before: SessionDocument) -> SessionDocument:
        """Document that a response shows; most refusals do not change it."""
        if self.document is None or (self.reason is not None and self.document.finish is None):
            return before
        return self.document

    def count(self) -> None:
        """Count the judgement, unless the view was judged before."""
        if self.took_ms is None:
            return
        values: dict[str, float] = {"Views": 1, "FitTime": self.took_ms}
        if self.reason is not None:
            values["Refusals"] = 1
        elif self.document is not None and self.document.finish is not None:
            values |= {"Calibrations": 1, "ViewsPerSession": len(self.document.views)}
        metrics.count(reason=self.reason, **values)


@dataclass(frozen=True)
class Batch:
    """Session after a batch of views, their results, and new judgements."""

    document: SessionDocument
    results: list[BatchResult]
    judged: list[Judgement]


class Course:
    """Course of one session.

    `who`, `where`: keyed hashes of the contributor and of their source. `explains`: with advice, which
    `explain` adds otherwise.
    """

    def __init__(
        self,
        document: SessionDocument,
        now: int,
        who: str = "",
        where: str | None = "",
        *,
        explains: bool = True,
    ) -> None:
        self.document = document
        self._now, self._who, self._where, self._explains = now, who, where, explains
        self._estimate: Estimate | None = None
        self._session = Session.of(document)

    def judge(self, view: ViewDocument) -> Judgement:
        """Judge the view."""
        begun = time.perf_counter()
        judged = self._judge(view)
        return replace(judged, took_ms=round((time.perf_counter() - begun) * 1e3, 1))

    def _judge(self, view: ViewDocument) -> Judgement:
        document, session = self.document, self._session
        rules, views, excluded = session.rules, session.views, session.excluded
        target = None if rules.recorded else open_target(document, session)
        observation = rules.board.view(view.ids, view.points)
        quarantined = views_of(rules.board, document.doubted)
        decision = rules.judge(
            views, target, observation, excluded, quarantined, _history(document), explain=self._explains
        )
        if decision.seed_rejected:
            document, rules = session_rules.without_seed(document), rules.without_seed()
        estimate = decision.estimate
        if not decision.accepted or estimate is None:
            hint = Hint(code=decision.hint.code, text=decision.hint.text) if decision.hint else None
            refused = _refused(document, view, decision)
            self._session = Session(rules, views, excluded)
            if refused is not None and _history(refused).is_exhausted(len(views) - len(excluded)):
                refused = self._stop(refused, "nothing_new")
            self.document = refused or self.document
            return Judgement(refused, decision.reason, hint)
        everything = [*views, observation]
        following = None
        if not (estimate.converged or rules.recorded):
            unreached = target_poses((*document.unreached, *document.skipped))
            following = rules.next_target(everything, estimate, unreached=unreached).to_record()
        judged = _judged_views((*document.views, view), estimate)
        stored = _estimate_document(estimate, self._now)
        changed = session_rules.with_view(document, judged, stored, following, decision.on_target)
        if estimate.converged:
            changed = self._end(changed, estimate, everything)
        self.document, self._estimate = changed, estimate
        self._session = Session(rules, everything, dict(estimate.excluded))
        return Judgement(changed)

    def explain(self) -> None:
        """Add the advice about the views accepted, unless the time is up."""
        if self._estimate is not None:
            with suppress(DeadlineError):
                estimate = self._session.rules.explain(self._session.views, self._estimate)
                stored = _estimate_document(estimate, self._now)
                self.document = session_rules.with_advice(self.document, stored)

    def without_view(self, index: int) -> SessionDocument | None:
        """Undo a view; None if it was undone before. Raises ConflictError or NotFoundError."""
        if self.document.rig is not None:
            raise rig_rules.in_rig()
        left = session_rules.without_view(self.document, index)
        return None if left is None else self.without_views(left)

    def without_views(self, left: tuple[ViewDocument, ...], *, with_target: bool = True) -> SessionDocument:
        """Session with the views that are left, fitted again, and another target."""
        document = self.document
        session = Session.of(document.model_copy(update={"views": left}))
        estimate = session.rules.reconcile(session.views, session.excluded)
        target = None
        if with_target:
            unreached = target_poses(document.unreached)
            target = session.rules.next_target(session.views, estimate, unreached=unreached).to_record()
        judged = _judged_views(left, estimate)
        return session_rules.with_views(document, judged, _estimate_document(estimate, self._now), target)

    def finish(self) -> SessionDocument | None:
        """End a recording; None if it has ended. Raises ConflictError or CalibrationError."""
        if self.document.finish is not None:
            return None
        if self.document.rig is not None:
            raise rig_rules.in_rig()
        session_rules.require_finishable(self.document)
        return self.finished()

    def finished(self) -> SessionDocument:
        """End a session with the views that agree; raises CalibrationError."""
        ended = self._stop(self.document, "asked")
        if ended.finish is None:
            raise CalibrationError("no_fit", "no camera explains these views")
        return ended

    def _stop(self, document: SessionDocument, end: Literal["nothing_new", "asked"]) -> SessionDocument:
        """End a session, if it has a fit, before it converges."""
        session = self._session
        estimate = session.estimate().with_cause(session.views)
        estimate = replace(estimate, progress=1.0, end=end)
        judged = _judged_views(document.views, estimate)
        stopped = session_rules.with_estimate(document, judged, _estimate_document(estimate, self._now))
        return self._end(stopped, estimate, session.views)

    def _end(self, document: SessionDocument, estimate: Estimate, views: Sequence[View]) -> SessionDocument:
        """End a session with this estimate of its views, if that has a fit."""
        from calibsolver.quality import report  # only an end needs it
        from calibsolver.quality.rivals import with_rivals

        if estimate.calibration is None:
            return document
        indices = [view.index for view in document.views if view.set_aside is None]
        used = [one for i, one in enumerate(views) if i not in estimate.excluded]
        judged = with_rivals(estimate.calibration, used)
        fit = FitRecord.model_validate(record_covered(judged, Coverage.of(judged, used)))
        ended = document.model_copy(update={"estimate": document.estimate.model_copy(update={"fit": fit})})
        described = report.describe(judged, used, indices)
        return session_result.with_finish(ended, self._now, self._who, FIT_VERSION, described, self._where)


def judge_batch(
    document: SessionDocument, request: BatchRequest, now: int, seconds_left: Callable[[], float]
) -> Batch:
    """Judge as many views of a batch as the time allows."""
    replayed = session_rules.validate_batch(document, request.index, request.views)
    course = Course(document, now, explains=False)
    results: list[BatchResult] = []
    judgements: list[Judgement] = []
    for view, replay in zip(request.views, replayed, strict=True):
        if replay is not None:
            results.append(accepted_result(replay))
            continue
        if results and seconds_left() < _MIN_BATCH_S:
            break
        sent = ViewDocument(index=course.document.next_index, ids=view.ids, points=view.points)
        try:
            judged = course.judge(sent)
        except DeadlineError:
            if not results:
                raise
            break
        except CalibrationError:
            judged = Judgement(reason="degenerate", took_ms=0.0)
        judgements.append(judged)
        if judged.reason is None:
            results.append(accepted_result(course.document.views[-1]))
        else:
            results.append(BatchResult(accepted=False, index=None, reason=judged.reason, error=None))
    if len(results) == len(request.views):
        course.explain()
    return Batch(course.document, results, judgements)


def open_target(document: SessionDocument, session: Session) -> TargetPose:
    """Session's open target, chosen now if there is none."""
    if document.target is None:
        return session.rules.next_target(session.views, session.estimate())
    target = TargetPose.from_dict(document.target)
    active = [view for i, view in enumerate(session.views) if i not in session.excluded]
    return session.rules.redraw(target, active, current_camera(document, session.rules))


def _refused(document: SessionDocument, view: ViewDocument, decision: ViewDecision) -> SessionDocument | None:
    """Document to store after a refusal; None if nothing changes."""
    if decision.quarantine:
        return session_rules.with_quarantined(document, view)
    if decision.reason == "duplicate":
        return document.model_copy(update={"duplicates": document.duplicates + 1})
    return document if decision.seed_rejected else None


def _estimate_document(estimate: Estimate, now: int) -> EstimateDocument:
    fit, uncertainty, coverage = estimate.calibration, estimate.uncertainty, estimate.coverage
    stated = None
    if uncertainty and coverage:
        stated = {"rms": uncertainty.rms, "max": uncertainty.max, **uncertainty_members(coverage)}
    record: dict[str, Any] = {
        "time": now,
        "fit": record_covered(fit, coverage) if fit and coverage else None,
        "uncertainty": stated,
        "progress": estimate.progress,
        "converged": estimate.converged,
        "end": estimate.end,
        "advice": [{"code": advice.code, "text": advice.text} for advice in estimate.advice],
        "suggested_model": estimate.suggested_model,
    }
    return EstimateDocument.model_validate(record)


def _judged_views(views: Sequence[ViewDocument], estimate: Estimate) -> tuple[ViewDocument, ...]:
    """Views with their errors, px, and the reasons of those that are excluded."""
    judged = []
    for i, (view, rms) in enumerate(zip(views, estimate.view_errors, strict=True)):
        reason = estimate.excluded.get(i)
        aside = reason and SetAside.model_validate({"reason": reason.reason, "detail": reason.detail})
        judged.append(view.model_copy(update={"rms": rms, "set_aside": aside}))
    return tuple(judged)
