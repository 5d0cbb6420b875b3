"""Session: starts one guided capture, shows its state, or forgets it."""

from __future__ import annotations

from starlette.responses import Response

from calibdb.camera_key import camera_key
from calibdb.errors import ConflictError, NotFoundError
from calibdb.http import application, metrics
from calibdb.rules import session_rules
from calibdb.rules.session_state import state
from calibdb.schema import FitRecord, SessionDocument, SessionRequest
from calibdb.store import Store


def start(call: application.Call) -> Response:
    """Start the session; idempotent: the same content is answered again."""
    ticket = call.session(charge="poses")
    sid = ticket.sid
    request = call.json(SessionRequest)
    now = call.service.now
    store = call.service.store
    who = call.service.contributor(call.address, ticket.token)

    def begin(version: int) -> SessionDocument:
        if version > 1:  # started anew, it can be published anew: a capture as any other
            call.service.charge(call.service.token_of(ticket), "sessions", call.address)
        return session_rules.begin(request, sid, version, now, find_seed(store, request), who)

    document, made = store.sessions.start(sid, now, begin)
    if not session_rules.is_same_start(
        document, session_rules.begin(request, sid, document.first_version, now)
    ):
        raise ConflictError(
            "A session with other content is running under this session id; forget it first.",
            kind="other-content",
        )
    if made:
        metrics.count(now, Sessions=1)
    return application.json_response(state(document), 201)


def find_seed(store: Store, request: SessionRequest) -> FitRecord | None:
    """Find an initial camera: what others measured of this camera, or the operator's guess, or None."""
    key = camera_key(request.camera, request.platform)
    place = (request.img_size, request.zoom, request.distortion_model)
    return session_rules.find_seed(store.consensuses.of(key), *place) or store.priors.find(key, *place)


def show(call: application.Call) -> Response:
    """Answer with the session's state."""
    document = call.service.store.sessions.get(call.session(charge="poses").sid)
    return application.json_response(state(document))


def forget(call: application.Call) -> Response:
    """Forget the session's views. What it published when it converged stays."""
    if not call.service.store.sessions.forget(call.session(charge="poses").sid, call.service.now):
        raise NotFoundError("No session was started under this session id.", kind="no-session")
    return application.no_content()


handler = application.handler(application.route("/v1/session", POST=start, GET=show, DELETE=forget))
