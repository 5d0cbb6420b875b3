"""Rig: cameras that do not move against each other, each a session, captured together.

Everything after the end of a rig follows from its document and is idempotent.
"""

import secrets

from starlette.responses import Response

from calibdb.compute import exports, rig_course
from calibdb.errors import InvalidError, NotFoundError
from calibdb.http import application, metrics
from calibdb.http.application import Call, json_response, route
from calibdb.rules import rig_rules
from calibdb.schema import MomentRequest, RigRequest
from calibdb.schema.rig import RIG_FORMATS
from calibdb.store import running_rigs


def create(call: Call) -> Response:
    """Make or find the rig of a session, and a fresh join code."""
    ticket, service = call.session(charge="poses"), call.service
    request = call.json(RigRequest)
    lead = running_rigs.Lead(ticket.sid, *call.contributor(ticket))
    code, secret = rig_rules.code_of(secrets.token_hex(8)), service.settings.contributor_secret
    opened = running_rigs.create(service.store, lead, request, code, secret, service.now)
    return json_response(opened, 201)


def show(call: Call) -> Response:
    """Show the rig, unless it has not changed; `skip=1`: with another target."""
    rig_id, store = call.path("id"), call.store
    by_session = call.is_session()
    if call.flag("skip"):
        sid = call.session(charge="poses").sid
        rig_course.skip(call.with_time_for_a_rig(), rig_id, sid)
    elif not by_session:
        call.api_token()
    else:
        call.session()
    sent = call.request.headers.get("if-none-match", "")
    tag = rig_course.head_tag(store, rig_id) if sent else None
    if tag is not None and tag in sent:
        return Response(status_code=304, headers={"ETag": tag})
    if by_session:
        call.session(charge="poses")
    return _state_response(call)


def open_moment(call: Call) -> Response:
    """Open a moment."""
    sid = call.session(charge="poses").sid
    moment = call.json(MomentRequest).moment
    running_rigs.open_moment(call.store, call.path("id"), sid, moment, call.now)
    return _state_response(call, 201)


def undo_moment(call: Call) -> Response:
    """Undo a moment in all cameras."""
    sid = call.session(charge="views").sid
    rig_course.undo_moment(call.with_time_for_a_rig(), call.path("id"), sid, call.path("moment"))
    return _state_response(call)


def finish(call: Call) -> Response:
    """End the rig with the moments that agree."""
    sid = call.session(charge="views").sid
    ended = rig_course.finish(call.with_time_for_a_rig(), call.path("id"), sid)
    if ended:
        metrics.count(Calibrations=ended)
    return _state_response(call)


def forget(call: Call) -> Response:
    """Forget a running rig, and the sessions of its cameras."""
    sid = call.session(charge="poses").sid
    running_rigs.forget(call.store, call.path("id"), sid, call.now)
    return Response(status_code=204)


def result(call: Call) -> Response:
    """Result of a finished rig, or another tool's files of it."""
    name = call.request.query_params.get("format", "json")
    ticket = call.session(charge="poses") if call.is_session() else None
    token = call.api_token() if ticket is None else call.service.token_of(ticket)
    if name not in exports.RIG_WRITERS:
        raise InvalidError.field("format", f"must be one of {', '.join(RIG_FORMATS)}")
    state, _ = rig_course.state_of(call, call.path("id"), running=False)
    if state.result is None:
        raise NotFoundError("This rig has no result yet: its leader finishes it.", kind="rig-unfinished")
    if name == "json":
        return json_response(state.result)
    call.service.charge(token, "views", call.address)
    file = exports.rig_file(call.with_time_for_a_rig(), state.result, name)
    return exports.file_response(file, with_coverage=False)


def _state_response(call: Call, status: int = 200) -> Response:
    state, tag = rig_course.state_of(call.with_time_for_a_rig(), call.path("id"))
    return json_response(state, status, {"ETag": tag})


handler = application.handler(
    route("/v1/rigs", POST=create),
    route("/v1/rigs/{id}", GET=show, DELETE=forget),
    route("/v1/rigs/{id}/moments", POST=open_moment),
    route("/v1/rigs/{id}/moments/{moment}", DELETE=undo_moment),
    route("/v1/rigs/{id}/finish", POST=finish),
    route("/v1/rigs/{id}/result", GET=result),
)
