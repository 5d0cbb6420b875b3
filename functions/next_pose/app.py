"""Next target pose, as a picture to lay over the video or as numbers."""

from pydantic import JsonValue
from starlette.responses import Response

from calibdb.compute.target_pose import (
    DrawnTarget,
    PictureFormat,
    choosing_target,
    not_in_view,
    with_chosen_target,
)
from calibdb.http import application
from calibdb.http.application import Call, json_response, route
from calibdb.rules import rig_rules, session_rules
from calibdb.schema import SessionDocument
from calibdb.schema.membership import RigMembership

FORMATS: dict[str, PictureFormat] = {"image/jpeg": "jpeg", "image/png": "png"}
TYPES = (*FORMATS, "application/json")  # the first is the default


def show(call: Call) -> Response:
    """Show the open target pose; with `skip=1`, open another."""
    sid = call.session(charge="poses").sid
    media_type = call.negotiate_media_type(TYPES)
    skip = call.flag("skip")
    refused: dict[str, JsonValue] | None = None

    def change(document: SessionDocument) -> SessionDocument | None:
        nonlocal refused
        session_rules.require_open(document)
        # When another request got ahead of ours, what it opened is not what the user wanted to skip.
        if document.target is not None and (not skip or refused not in (None, document.target)):
            return None
        refused = document.target
        return with_chosen_target(session_rules.without_target(document))

    running = call.store.sessions.get(sid)
    if running.rig is not None:
        call = call.with_time_for_a_rig()
    with choosing_target(call):
        if running.rig is not None:
            return _respond(running.next_index, _in_rig(call, running, running.rig), media_type)
        document = call.store.sessions.revise(sid, call.now, change)
    return _respond(document.next_index, DrawnTarget.of(document), media_type)


def _respond(index: int, drawn: DrawnTarget, media_type: str) -> Response:
    headers = {"Vary": "Accept, Authorization"}
    if media_type == "application/json":
        return json_response(drawn.pose(index), headers=headers)
    return Response(drawn.picture(FORMATS[media_type]), headers=headers, media_type=media_type)


def _in_rig(call: Call, document: SessionDocument, place: RigMembership) -> DrawnTarget:
    from calibdb.compute import rig_course  # other sessions do not wait for it

    session_rules.require_open(document)
    rig, _ = rig_course.load(call.store, place.id)
    rig_rules.require_open(rig.document)
    estimate = rig_course.ensure_estimate(call, rig)
    if estimate.target is None:
        raise not_in_view()
    fit = estimate.fit.cameras[place.position] if estimate.fit else None
    return DrawnTarget.of_rig(document, estimate.target, fit)


handler = application.handler(route("/v1/session/pose", GET=show))
