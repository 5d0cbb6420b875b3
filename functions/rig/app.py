"""Rig: cameras that do not move against each other, each a session, captured together.

The leader, whose session is that of camera 0, makes the rig, opens moments, undoes them and ends it. A rig
that ends says so first in its own document, with all that its end is to be; everything after that follows
from this document and is idempotent.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from starlette.responses import Response

import calibsolver
from calibdb.errors import ConflictError, InvalidError, NotFoundError
from calibdb.http import application, metrics
from calibdb.rules import rig_result, rig_rules, session_rules
from calibdb.rules.rig_state import Rig, state
from calibdb.schema import (
    MomentRequest,
    RigDocument,
    RigEstimateDocument,
    RigFinish,
    RigOpened,
    RigRequest,
    RigState,
    SessionDocument,
)
from calibdb.schema.rig import RIG_FORMATS
from calibdb.schema.rig_documents import CodeDocument, EndingDocument
from calibdb.store import endings, running_rigs
from calibsolver import CalibrationError, Camera, DeadlineError, deadline
from calibsolver.capture import stored
from calibsolver.rig import estimate, formats

SOLVER = calibsolver.FIT_VERSION
RIG_WRITERS = {name: name for name in RIG_FORMATS} | {"opencv_stereo": "opencv-yaml"}


def create(call: application.Call) -> Response:
    """Make the rig of a session, or find it, and a fresh join code."""
    ticket = call.session(charge="poses")
    request = call.json(RigRequest)
    store, now = call.service.store, call.service.now
    secret = call.service.settings.contributor_secret
    session = store.sessions.get(ticket.sid)
    rig_id = rig_rules.rig_id(secret, session)
    rig_rules.with_lead(session, rig_id)
    rig_rules.require_linking_board(session.board)
    who = call.service.contributor(call.address, ticket.token)
    document, _ = store.rigs.start(rig_id, now, lambda _: rig_rules.begin(request, rig_id, session, who, now))
    rig_rules.require_same_start(document, request)
    rig_rules.require_open(document)
    where = call.service.source(call.address)
    store.sessions.update(ticket.sid, now, lambda known: (rig_rules.with_lead(known, rig_id, where), None))
    text = rig_rules.code_of(call.service.random_hex(8))
    until = now + rig_rules.CODE_LIFETIME_S
    code = CodeDocument(digest=rig_rules.code_digest(secret, text), until=until)
    for digest in store.rigs.update(rig_id, now, lambda known: rig_rules.with_code(known, code, now)):
        store.rig_codes.remove(digest)
    store.rig_codes.put(code.digest, rig_id, until)
    return application.json_response(RigOpened(rig_id=rig_id, join_code=text, expires_at=until), 201)


def show(call: application.Call) -> Response:
    """Answer with the state of the rig, or that it has not changed; `skip=1`: with another target."""
    rig_id, store = call.path("id"), call.service.store
    by_session = call.is_session()
    if call.flag("skip"):
        rig = leading(call, rig_id)
        rig_rules.require_open(rig.document)
        skip(call, rig)
    elif not by_session:
        call.api_token()
    else:
        call.session()
    sent = call.request.headers.get("if-none-match", "")
    tag = running_rigs.head_tag(store, rig_id, SOLVER) if sent else None
    if tag is not None and tag in sent:
        return Response(status_code=304, headers={"ETag": tag})
    if by_session:
        call.session(charge="poses")
    known, tag = state_of(call, rig_id)
    return application.json_response(known, headers={"ETag": tag})


def skip(call: application.Call, rig: Rig) -> None:
    """Note that the target is not wanted."""
    basis, known = rig.basis(SOLVER), current_estimate(call, rig)

    def change(document: RigDocument) -> tuple[RigDocument, None]:
        return rig_rules.with_skip(document, basis, known.target_pose), None

    call.service.store.rigs.update(rig.document.rig, call.service.now, change)


def open_moment(call: application.Call) -> Response:
    """Open a moment: from now on cameras may send views of it."""
    ticket = call.session(charge="poses")
    moment, now = call.json(MomentRequest).moment, call.service.now
    rig_id = call.path("id")

    def change(document: RigDocument) -> tuple[RigDocument | None, None]:
        rig_rules.require_leader(document, ticket.sid)
        return rig_rules.with_moment(document, moment, now), None

    call.service.store.rigs.update(rig_id, now, change)
    known, tag = state_of(call, rig_id)
    return application.json_response(known, 201, {"ETag": tag})


def undo_moment(call: application.Call) -> Response:
    """Undo a moment in all cameras; what of it comes late counts for nothing."""
    ticket = call.session(charge="views")
    moment, rig_id = call.path("moment"), call.path("id")
    store, now = call.service.store, call.service.now

    def change(document: RigDocument) -> tuple[RigDocument | None, None]:
        rig_rules.require_leader(document, ticket.sid)
        return rig_rules.without_moment(document, moment), None

    def without(session: SessionDocument) -> tuple[SessionDocument | None, None]:
        left = tuple(view for view in session.views if view.moment != moment)
        elsewhere = session.rig is None or session.rig.id != rig_id
        if elsewhere or len(left) == len(session.views) or session.finish is not None:
            return None, None
        rules, views, excluded = stored.parse(session.model_copy(update={"views": left}).model_dump())
        found = rules.reconcile(views, excluded)
        known = session_rules.estimate_document(stored.estimate_record(found), now)
        return session_rules.with_views(session, left, known, stored.view_statuses(found), None), None

    store.rigs.update(rig_id, now, change)
    rig, _ = running_rigs.load(store, rig_id, SOLVER)
    with in_time(call.with_time_for_a_rig()):
        for _, session in rig.present:
            if any(view.moment == moment for view in session.views):
                store.sessions.update(session.session, now, without)
    known, tag = state_of(call, rig_id)
    return application.json_response(known, headers={"ETag": tag})


def finish(call: application.Call) -> Response:
    """End the rig with the moments that agree: fix its result, then publish it and its cameras."""
    ticket = call.session(charge="views")
    rig_id, store, now = call.path("id"), call.service.store, call.service.now
    document = store.rigs.find(rig_id)
    if document is not None:
        rig_rules.require_leader(document, ticket.sid)
        if document.finish is None:
            rig, _ = running_rigs.load(store, rig_id, SOLVER)
            outcome = end(call, rig)

            def change(known: RigDocument) -> tuple[RigDocument | None, RigDocument]:
                if known.finish is not None:
                    return None, known
                ended = rig_rules.with_finish(known, rig.document, outcome)
                return ended, ended

            document = store.rigs.update(rig_id, now, change)
            metrics.count(call.service.clock(), Calibrations=len(document.members))
        endings.publish_rig(store, document, now)
    known, tag = state_of(call, rig_id)
    return application.json_response(known, headers={"ETag": tag})


def end(call: application.Call, rig: Rig) -> RigFinish:
    """Decide on everything that the end of a rig is to be."""
    with in_time(call.with_time_for_a_rig()):
        known = RigEstimateDocument(**estimate(rig.solver_record(rig.basis(SOLVER)), final=True))
        fit = rig_result.require_finishable(rig, known)
        try:
            ended = [ending(rig, session, call.service.now) for _, session in rig.present]
        except CalibrationError as error:
            raise ConflictError(
                f"A camera has no calibration: {error.message}", kind="too-few-views"
            ) from error
    result = rig_result.finished(rig, known, fit, ended, SOLVER, call.service.now)
    return RigFinish(calibration=result, endings=tuple(ended))


def ending(rig: Rig, session: SessionDocument, now: int) -> EndingDocument:
    """Decide on the end of one camera's session, with its views of the moments that count."""
    counted = {name for name, _ in rig.moments()}
    kept = tuple(view for view in session.views if view.moment in counted)
    counted_session = session.model_copy(update={"views": kept})
    outcome = stored.finish(counted_session.model_dump())
    return rig_rules.ending_of(counted_session, outcome, SOLVER, now)


def forget(call: application.Call) -> Response:
    """Forget a running rig, and the sessions of its cameras."""
    sid = call.session(charge="poses").sid
    rig_id, store, now = call.path("id"), call.service.store, call.service.now
    document = store.rigs.find(rig_id)
    if document is not None:
        rig_rules.require_leader(document, sid)
        rig_rules.require_open(document)
        for code in document.codes:
            store.rig_codes.remove(code.digest)
        for member in document.members:
            session = store.sessions.find(member.session) if member else None
            # A session that left may be a camera of another rig by now.
            if member is not None and session is not None and session.rig and session.rig.id == rig_id:
                store.sessions.forget(member.session, now)
    if not store.rigs.forget(rig_id, now):
        raise NotFoundError("There is no rig with this id.", kind="no-rig")
    return application.no_content()


def result(call: application.Call) -> Response:
    """Answer with the result of a finished rig, or with another tool's files of it."""
    name = call.request.query_params.get("format", "json")
    if call.is_session():
        ticket = call.session(charge="poses")
        token = call.service.token_of(ticket)
    else:
        token = call.api_token()
    if name not in RIG_WRITERS:
        raise InvalidError.field("format", f"must be one of {', '.join(RIG_FORMATS)}")
    known, _ = state_of(call, call.path("id"), running=False)
    found = known.result
    if found is None:
        raise NotFoundError("This rig has no result yet: its leader finishes it.", kind="rig-unfinished")
    if name == "json":
        return application.json_response(found)
    call.service.charge(token, "views", call.address)
    call = call.with_time_for_a_rig()
    source = formats.RigSource(
        cameras=[Camera.from_record(one.model_dump()) for one in found.calibrations],
        poses=np.array([[*one.rvec, *one.tvec] for one in found.extrinsics]),
        unit=found.unit,
        names=[f"cam{i} {one.camera}" for i, one in enumerate(found.calibrations)],
        identifier=found.rig_id,
        record=found.model_dump(),
    )
    try:
        with deadline.limit(call.seconds_left):
            written = formats.write(source, RIG_WRITERS[name])
    except CalibrationError as error:
        raise InvalidError.field("format", error.message) from error
    except DeadlineError as error:
        slow = "takes longer to compute than a request may; ask for another format"
        raise call.out_of_time(InvalidError.field("format", slow)) from error
    headers = {
        "Content-Disposition": f'attachment; filename="{written.filename}"',
        "X-Conversion-Error": f"{written.error:.6g}",
    }
    if written.warning:
        headers["X-Conversion-Warning"] = written.warning
    return Response(written.content, 200, headers, written.media_type)


def state_of(call: application.Call, rig_id: str, *, running: bool = True) -> tuple[RigState, str]:
    """Return state and tag of a rig, running or finished; raises NotFoundError."""
    store = call.service.store
    document = store.rigs.find(rig_id)
    ended = document.finish.calibration if document and document.finish else None
    if document is None:
        ended = store.rigs.calibration(rig_id)
    if ended is not None:
        return ended.state, running_rigs.head_tag(store, rig_id, SOLVER) or f'"{ended.id}"'
    rig, tag = running_rigs.load(store, rig_id, SOLVER)
    return state(rig, current_estimate(call, rig) if running else RigEstimateDocument()), tag


def leading(call: application.Call, rig_id: str) -> Rig:
    """Return a running rig that the caller leads."""
    ticket = call.session(charge="poses")
    rig, _ = running_rigs.load(call.service.store, rig_id, SOLVER)
    rig_rules.require_leader(rig.document, ticket.sid)
    return rig


def current_estimate(call: application.Call, rig: Rig) -> RigEstimateDocument:
    """Return fit and target of a rig, computed now if they are not stored yet: that counts as a view does."""
    call = call.with_time_for_a_rig()
    with in_time(call):
        compute = call.charged(estimate, DeadlineError)
        return running_rigs.ensure_estimate(call.service.store, rig, SOLVER, compute)


@contextmanager
def in_time(call: application.Call) -> Iterator[None]:
    """Compute within the call's time; raises ConflictError or UnavailableError where that is too short."""
    try:
        with deadline.limit(call.seconds_left):
            yield
    except DeadlineError as error:
        raise call.out_of_time(ConflictError(running_rigs.TOO_SLOW, kind="too-slow")) from error


handler = application.handler(
    application.route("/v1/rigs", POST=create),
    application.route("/v1/rigs/{id}", GET=show, DELETE=forget),
    application.route("/v1/rigs/{id}/moments", POST=open_moment),
    application.route("/v1/rigs/{id}/moments/{moment}", DELETE=undo_moment),
    application.route("/v1/rigs/{id}/finish", POST=finish),
    application.route("/v1/rigs/{id}/result", GET=result),
)
