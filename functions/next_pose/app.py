"""Next target pose, as a picture to lay over the video or as numbers."""

from __future__ import annotations

from typing import Literal

from pydantic import JsonValue
from starlette.responses import Response

from calibdb.errors import ConflictError
from calibdb.http import application
from calibdb.rules import rig_rules, session_rules
from calibdb.schema import Pose, SessionDocument
from calibdb.schema.membership import RigMembership
from calibdb.store import running_rigs
from calibsolver import FIT_VERSION, Board, CalibrationError, Camera, DeadlineError, deadline, guidance
from calibsolver.capture import stored
from calibsolver.guidance import overlay

Format = Literal["jpeg", "png"]
FORMATS: dict[str, Format] = {"image/jpeg": "jpeg", "image/png": "png"}
TYPES = (*FORMATS, "application/json")  # the first is the default


def show(call: application.Call) -> Response:
    """Answer with the open target pose; with `skip=1`, open one of another kind."""
    sid = call.session(charge="poses").sid
    media_type = call.negotiate_media_type(TYPES)
    skip = call.flag("skip")
    refused: dict[str, JsonValue] | None = None

    def change(document: SessionDocument) -> tuple[SessionDocument | None, SessionDocument]:
        nonlocal refused
        session_rules.require_open(document)
        # When another request got ahead of ours, what it opened is not what the user wanted to skip.
        if document.target is not None and (not skip or refused not in (None, document.target)):
            return None, document
        refused = document.target
        changed = choose(session_rules.without_target(document))
        return changed, changed

    running = call.service.store.sessions.get(sid)
    if running.rig is not None:
        call = call.with_time_for_a_rig()
    try:
        with deadline.limit(call.seconds_left):
            if running.rig is not None:
                return in_rig(call, running, running.rig, media_type)
            document = call.service.store.sessions.update(sid, call.service.now, change)
    except CalibrationError as error:
        raise ConflictError(f"No target can be chosen: {error.message}; undo one.") from error
    except DeadlineError as error:
        raise call.out_of_time(
            ConflictError("The views take longer to compute than a request may; undo one.", kind="too-slow")
        ) from error
    return respond(document.next_index, *redraw_target(document), media_type)


def respond(
    index: int, board: Board, camera: Camera, target: guidance.TargetPose, media_type: str
) -> Response:
    """Answer with a target as numbers, or as a picture of it."""
    headers = {"Vary": "Accept, Authorization"}
    if media_type == "application/json":
        pose = Pose.model_validate({**target.to_dict(), "index": index})
        return application.json_response(pose, headers=headers)
    picture = overlay.render(board, camera, target, FORMATS[media_type])
    return Response(picture, headers=headers, media_type=media_type)


def in_rig(
    call: application.Call, document: SessionDocument, place: RigMembership, media_type: str
) -> Response:
    """Answer with the target of the session's rig, as this camera is to see it."""
    # Here and not above: other sessions need not wait for it.
    from calibsolver.rig import estimate

    session_rules.require_open(document)
    rig, _ = running_rigs.load(call.service.store, place.id, FIT_VERSION)
    rig_rules.require_open(rig.document)
    compute = call.charged(estimate, DeadlineError)
    found = running_rigs.ensure_estimate(call.service.store, rig, FIT_VERSION, compute)
    seen = found.target.cameras if found.target else ()
    view = next((one for one in seen if one.position == place.position), None)
    if view is None or found.target is None:
        raise ConflictError(
            "This camera is not to see the board now: the target is for others.",
            kind="not-in-view",
        )
    fit = found.fit.cameras[place.position] if found.fit else document.estimate.fit
    rules, _, _ = stored.parse(document.model_dump())
    camera = Camera.from_record(fit.model_dump()) if fit else rules.camera(None)
    values = {**view.model_dump(), "purpose": found.target.purpose, "gain": 0.0}
    target = guidance.TargetPose.from_dict(values)
    return respond(document.next_index, rules.board, camera, target, media_type)


def choose(document: SessionDocument) -> SessionDocument:
    """Return the document with the target open that helps most, unlike those that the user did not want."""
    rules, views, excluded = stored.parse(document.model_dump())
    skipped, unreached = map(stored.parse_targets, (document.skipped, document.unreached))
    target = rules.next_target(views, rules.estimate(views, excluded), skipped, unreached)
    return session_rules.with_target(document, target.to_record())


def redraw_target(document: SessionDocument) -> tuple[Board, Camera, guidance.TargetPose]:
    """Return the board, the session's current camera, and the open target as this camera sees it."""
    rules, every, excluded = stored.parse(document.model_dump())
    fit = document.estimate.fit
    camera = Camera.from_record(fit.model_dump()) if fit else rules.camera(None)
    views = [view for i, view in enumerate(every) if i not in excluded]
    target = guidance.TargetPose.from_dict(document.target or {})
    return rules.board, camera, rules.redraw(target, views, camera)


handler = application.handler(application.route("/v1/session/pose", GET=show))
