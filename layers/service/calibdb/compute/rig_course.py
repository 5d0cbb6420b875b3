"""Course of a rig: its fit and target, moments undone, and its end."""

import hashlib
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager

from calibdb.compute.session_course import Course
from calibdb.compute.values import in_time
from calibdb.errors import ConflictError
from calibdb.http import metrics
from calibdb.http.call import Call
from calibdb.rules import rig_result, rig_rules
from calibdb.rules.rig_state import Rig, state
from calibdb.schema import RigDocument, RigEstimateDocument, RigFinish, RigState, SessionDocument
from calibdb.schema.rig_documents import EndingDocument
from calibdb.store import Store, endings
from calibdb.store.ports import READERS
from calibsolver import FIT_VERSION, CalibrationError, DeadlineError
from calibsolver.rig import estimate

_TOO_SLOW = "These moments take longer to compute than a request may; undo some of them."


def _computing_moments(call: Call) -> AbstractContextManager[None]:
    return in_time(call, ConflictError(_TOO_SLOW, kind="too-slow"))


def load(store: Store, rig_id: str) -> tuple[Rig, str]:
    """Running rig and the tag of its state; raises NotFoundError."""
    document, version = store.rigs.get_version(rig_id)
    sessions, versions = zip(*_sessions(store, document), strict=True)
    return Rig(document, sessions), _tag(version, versions)


def head_tag(store: Store, rig_id: str) -> str | None:
    """Tag of a running rig's state, from the index; None if it does not run."""
    head = store.rigs.head(rig_id)
    if head is None or head.forgotten:
        return None
    names = head.facts.get("sessions")
    versions = [_version(store, name) for name in (names if isinstance(names, list) else [])]
    return _tag(head.version, versions)


def ensure_estimate(call: Call, rig: Rig) -> RigEstimateDocument:
    """Fit and target of a rig; computing them counts as a view.

    Raises ConflictError if these moments take or took too long.
    """
    rigs, basis = call.store.rigs, rig.basis(FIT_VERSION)
    digest = rig.digest(basis)
    stored = rigs.estimate(rig.document.rig, digest)
    if stored is None:
        call.charge_view()
        try:
            stored = RigEstimateDocument.model_validate(estimate(rig.solver_record(basis)))
        except DeadlineError:
            if call.processor_s_left > 0:
                raise  # on a busy machine
            metrics.count(ComputeTimeouts=1)
            stored = RigEstimateDocument(too_slow=True)
        rigs.keep_estimate(rig.document.rig, digest, stored)
    if stored.too_slow:
        raise ConflictError(_TOO_SLOW, kind="too-slow")
    return stored


def state_of(call: Call, rig_id: str, *, running: bool = True) -> tuple[RigState, str]:
    """State and tag of a rig, with fit and target if `running`; raises NotFoundError."""
    store = call.store
    document = store.rigs.find(rig_id)
    ended = document.finish.calibration if document and document.finish else None
    if document is None:
        ended = store.rigs.calibration(rig_id)
    if ended is not None:
        return ended.state, head_tag(store, rig_id) or f'"{ended.id}"'
    rig, tag = load(store, rig_id)
    if not running:
        return state(rig, RigEstimateDocument()), tag
    with _computing_moments(call):
        return state(rig, ensure_estimate(call, rig)), tag


def skip(call: Call, rig_id: str, leader: str) -> None:
    """Note that the target is not wanted; raises ForbiddenError."""
    rig, _ = load(call.store, rig_id)
    rig_rules.require_leader(rig.document, leader)
    rig_rules.require_open(rig.document)
    basis = rig.basis(FIT_VERSION)
    with _computing_moments(call):
        pose = ensure_estimate(call, rig).target_pose
    call.store.rigs.revise(rig_id, call.now, lambda document: rig_rules.with_skip(document, basis, pose))


def undo_moment(call: Call, rig_id: str, leader: str, moment: str) -> None:
    """Undo a moment in all cameras."""
    store, now = call.store, call.now

    def change(document: RigDocument) -> RigDocument | None:
        rig_rules.require_leader(document, leader)
        return rig_rules.without_moment(document, moment)

    def without(session: SessionDocument) -> SessionDocument | None:
        left = tuple(view for view in session.views if view.moment != moment)
        elsewhere = session.rig is None or session.rig.id != rig_id
        if elsewhere or len(left) == len(session.views) or session.finish is not None:
            return None
        return Course(session, now).without_views(left, with_target=False)

    store.rigs.revise(rig_id, now, change)
    rig, _ = load(store, rig_id)
    with _computing_moments(call):
        for _, session in rig.present:
            if any(view.moment == moment for view in session.views):
                store.sessions.revise(session.session, now, without)


def finish(call: Call, rig_id: str, leader: str) -> int:
    """End a rig and publish it; return the number of calibrations, 0 if it had ended."""
    store, now = call.store, call.now
    document, ended = store.rigs.find(rig_id), 0
    if document is None:
        return 0
    rig_rules.require_leader(document, leader)
    if document.finish is None:
        rig, _ = load(store, rig_id)
        outcome = _end(call, rig, now)
        document = store.rigs.revise(
            rig_id,
            now,
            lambda known: None if known.finish else rig_rules.with_finish(known, rig.document, outcome),
        )
        ended = len(document.members)
    endings.publish_rig(store, document, now)
    return ended


def _end(call: Call, rig: Rig, now: int) -> RigFinish:
    with _computing_moments(call):
        record = rig.solver_record(rig.basis(FIT_VERSION))
        estimate_document = RigEstimateDocument(**estimate(record, final=True))
        fit = rig_result.require_finishable(rig, estimate_document)
        try:
            ended = [_ending(rig, session, now) for _, session in rig.present]
        except CalibrationError as error:
            raise ConflictError(
                f"A camera has no calibration: {error.message}", kind="too-few-views"
            ) from error
    result = rig_result.finished(rig, estimate_document, fit, ended, FIT_VERSION, now)
    return RigFinish(calibration=result, endings=tuple(ended))


def _ending(rig: Rig, session: SessionDocument, now: int) -> EndingDocument:
    counted = {name for name, _ in rig.moments()}
    views = tuple(view for view in session.views if view.moment in counted)
    with_counted = session.model_copy(update={"views": views})
    course = Course(with_counted, now, session.contributor or "", session.source)
    return rig_rules.ending_of(course.finished())


def _sessions(store: Store, document: RigDocument) -> list[tuple[SessionDocument | None, int]]:
    """Sessions of a rig by position, with their versions or 0."""
    names = [member.session if member else "" for member in document.members]

    def read(name: str) -> tuple[SessionDocument | None, int]:
        version = store.sessions.find_version(name) if name else None
        # A session restarted without the rig is not part of it.
        if version is None or version[0].rig is None or version[0].rig.id != document.rig:
            return None, version[1] if version else 0
        return version

    with ThreadPoolExecutor(min(READERS, len(names))) as readers:
        return list(readers.map(read, names))


def _version(store: Store, name: str) -> int:
    head = store.sessions.head(name) if name else None
    return 0 if head is None or head.forgotten else head.version


def _tag(version: int, versions: Sequence[int]) -> str:
    text = "\n".join(map(str, (FIT_VERSION, version, *versions)))
    return f'"{hashlib.sha256(text.encode()).hexdigest()[:32]}"'
