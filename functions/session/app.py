"""One guided capture: starts it, shows how far it has come, forgets it."""

from __future__ import annotations

from starlette.responses import Response

from calibdb import capture, http
from calibdb.errors import ConflictError, NotFoundError
from calibdb.schema import SessionRequest


def start(call: http.Call) -> Response:
    """Start the session; asked again with the same content, answer again."""
    sid = call.session().sid
    request = call.json(SessionRequest)
    now = call.service.now
    document = call.service.store.sessions.start(
        sid, now, lambda version: capture.begin(request, sid, version, now)
    )
    if not capture.same_start(document, capture.begin(request, sid, document.first_version, now)):
        raise ConflictError("A session with other content runs under this session id.", kind="other-content")
    return http.answer(capture.state(document), 201)


def show(call: http.Call) -> Response:
    """Answer with the session's state."""
    document = call.service.store.sessions.get(call.session().sid)
    return http.answer(capture.state(document))


def forget(call: http.Call) -> Response:
    """Forget the session's views. What it published when it converged stays."""
    if not call.service.store.sessions.forget(call.session().sid, call.service.now):
        raise NotFoundError("No session was started under this session id.", kind="no-session")
    return http.nothing()


handler = http.handler(http.resource("/v1/session", POST=start, GET=show, DELETE=forget))
