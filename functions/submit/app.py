"""Submit: decide on a view, refit the camera and choose the next pose; undo a view; finish a recording.

Everything after the end of a session follows from its document and is idempotent, so that a repeated view
completes what a crash left undone.
"""

from starlette.responses import Response

from calibdb.compute.session_course import Batch, Course, Judgement, computing_views, judge_batch
from calibdb.http import application
from calibdb.http.application import Call, json_response, route
from calibdb.rules import rig_rules, session_rules
from calibdb.rules.session_result import batch_answer, state, view_answer
from calibdb.schema import BatchRequest, SessionDocument, ViewRequest
from calibdb.schema.session import LicenceRequest
from calibdb.store import endings, running_rigs


def submit(call: Call) -> Response:
    """Judge a view."""
    ticket = call.session(charge="views")
    request = call.json(ViewRequest)
    service = call.service
    who, where = call.contributor(ticket)

    def change(document: SessionDocument) -> tuple[SessionDocument | None, tuple[SessionDocument, Judgement]]:
        view = rig_rules.sent_view(document, request)
        if running_rigs.is_replay(service.store, document, view):
            return None, (document, Judgement())
        session_rules.validate_view(document, view)
        judged = Course(document, service.now, who, where).judge(view)
        return judged.document, (judged.shown(document), judged)

    with computing_views(call):
        document, judged = service.store.sessions.update(ticket.sid, service.now, change)
    judged.count()
    if document.finish is not None:
        endings.publish(service.store, document)
    return json_response(view_answer(document, judged.reason, judged.hint))


def submit_batch(call: Call) -> Response:
    """Judge several views of a recording, as many as the time allows."""
    sid = call.session(charge="views").sid
    request = call.json(BatchRequest, depth=2)
    service = call.service

    def change(document: SessionDocument) -> tuple[SessionDocument | None, Batch]:
        batch = judge_batch(document, request, service.now, call.seconds_left)
        return (None if batch.document is document else batch.document), batch

    with computing_views(call):
        batch = service.store.sessions.update(sid, service.now, change)
    for judged in batch.judged:
        judged.count()
    return json_response(batch_answer(batch.document, batch.results))


def remove(call: Call) -> Response:
    """Undo a view."""
    sid = call.session(charge="views").sid
    index, now = call.index("index"), call.now
    with computing_views(call):
        document = call.store.sessions.revise(sid, now, lambda known: Course(known, now).without_view(index))
    return json_response(state(document))


def finish(call: Call) -> Response:
    """End a session with the views that agree."""
    ticket = call.session(charge="views")
    service = call.service
    who, where = call.contributor(ticket)
    with computing_views(call):
        document = service.store.sessions.revise(
            ticket.sid, service.now, lambda known: Course(known, service.now, who, where).finish()
        )
    endings.publish(service.store, document)
    return json_response(state(document))


def license_views(call: Call) -> Response:
    """Add a licence to a session and its calibration."""
    sid = call.session(charge="views").sid
    request = call.json(LicenceRequest)
    document = endings.license_session(call.store, sid, request, call.now)
    return json_response(state(document))


handler = application.handler(
    route("/v1/session/views", POST=submit),
    route("/v1/session/batch", POST=submit_batch),
    route("/v1/session/views/{index}", DELETE=remove),
    route("/v1/session/finish", POST=finish),
    route("/v1/session/licence", POST=license_views),
)
