"""Session: starts one guided capture, also as a camera of a rig, shows its state, or deletes it.

A rig's document names a session before it exists, for starts repeated after a crash.
"""

from starlette.responses import Response

from calibdb.camera_key import camera_key
from calibdb.errors import ConflictError, InvalidError, NotFoundError
from calibdb.estimate.estimator import EstimateQuery, starting_camera
from calibdb.http import application, metrics
from calibdb.http.application import Call, json_response, route
from calibdb.rules import rig_rules, session_rules
from calibdb.rules.session_result import state
from calibdb.rules.session_rules import find_seed as find_reliable_seed
from calibdb.schema import FitRecord, RigDocument, SessionDocument, SessionRequest
from calibdb.schema.membership import RigJoin, RigMembership
from calibdb.schema.rig_documents import MemberDocument
from calibdb.store import Store, running_rigs


def start(call: Call) -> Response:
    """Start the session; idempotent for the same content."""
    ticket = call.session(charge="poses")
    request = call.json(SessionRequest)
    sid, now, store = ticket.sid, call.now, call.store
    who = call.service.contributor(call.address, ticket.token)
    rig = where = None
    if request.rig is not None:
        rig = _place(call, sid, request, request.rig, who)
        where = call.service.source(call.address)

    def begin(version: int) -> SessionDocument:
        if version > 1:  # a restarted session is another capture, and can be published
            call.service.charge(call.service.token_of(ticket), "sessions", call.address)
        return session_rules.begin(request, sid, version, now, _find_seed(store, request), who, rig, where)

    document, made = store.sessions.start(sid, now, begin)
    session = session_rules.begin(request, sid, document.first_version, now, rig=rig)
    # The session that made a rig was started without one.
    if request.rig is None and document.rig is not None and document.rig.position == 0:
        session = session.model_copy(update={"rig": document.rig})
    if not session_rules.is_same_start(document, session):
        raise _other_content()
    if made:
        metrics.count(Sessions=1)
    return json_response(state(document), 201)


def _find_seed(store: Store, request: SessionRequest) -> FitRecord | None:
    """Initial camera: the consensus, the operator's guess, or the estimate."""
    key = camera_key(request.camera, request.platform)
    place = (request.img_size, request.zoom, request.distortion_model)
    seed = find_reliable_seed(store.consensuses.of(key), *place) or store.priors.find(key, *place)
    if seed is not None:
        return seed
    query = EstimateQuery(request.camera, request.platform, request.img_size, request.zoom)
    return starting_camera(query, request.distortion_model)


def _place(call: Call, sid: str, request: SessionRequest, wanted: RigJoin, who: str) -> RigMembership:
    """Find or take the session's place in its rig; raises InvalidError, TooManyError."""
    store, now = call.store, call.now
    running = store.sessions.find(sid)
    if running is not None:
        rig = running.rig
        if rig and wanted.position in (None, rig.position) and wanted.id in (None, rig.id):
            return rig  # the code may be used up by now
        raise _other_content()
    where, secret = call.service.source(call.address), call.service.settings.contributor_secret
    rig_id = running_rigs.named(store, wanted, where, secret, now)
    member = MemberDocument(session=sid, contributor=who, joined=now)

    def change(document: RigDocument) -> tuple[RigDocument | None, RigMembership]:
        gone = running_rigs.abandoned_positions(store, document, now - rig_rules.ABANDONED_S)
        return rig_rules.join(document, wanted, request.board, member, gone)

    try:
        return store.rigs.update(rig_id, now, change)
    except NotFoundError as error:  # finished long ago, or forgotten
        field = InvalidError.field("rig.id", "there is no running rig with this id")
        raise (rig_rules.wrong_code() if wanted.code is not None else field) from error


def _other_content() -> ConflictError:
    return ConflictError(
        "A session with other content is running under this session id; forget it first.",
        kind="other-content",
    )


def show(call: Call) -> Response:
    """Show the session."""
    document = call.store.sessions.get(call.session(charge="poses").sid)
    return json_response(state(document))


def forget(call: Call) -> Response:
    """Forget the session's views; what it published stays."""
    if not call.store.sessions.forget(call.session(charge="poses").sid, call.now):
        raise NotFoundError("No session was started under this session id.", kind="no-session")
    return Response(status_code=204)


handler = application.handler(route("/v1/session", POST=start, GET=show, DELETE=forget))
