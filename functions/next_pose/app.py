"""Next target pose, as a picture to lay over the video or as numbers."""

from __future__ import annotations

from typing import Literal

from pydantic import JsonValue
from starlette.responses import Response

from calibdb.errors import ConflictError
from calibdb.http import application
from calibdb.rules import session_rules
from calibdb.schema import Pose, SessionDocument
from calibsolver import Board, CalibrationError, Camera, DeadlineError, deadline, guidance
from calibsolver.capture import Capture, exclusions
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

    try:
        with deadline.limit(call.seconds_left):
            document = call.service.store.sessions.update(sid, call.service.now, change)
    except CalibrationError as error:
        raise ConflictError(f"No target can be chosen: {error.message}; undo one.") from error
    except DeadlineError as error:
        raise call.out_of_time(
            ConflictError("The views take longer to compute than a request may; undo one.", kind="too-slow")
        ) from error
    headers = {"Vary": "Accept, Authorization"}
    if media_type == "application/json":
        _, _, target = drawn(document)
        pose = Pose.model_validate({**target.to_dict(), "index": document.next_index})
        return application.json_response(pose, headers=headers)
    return Response(draw(document, FORMATS[media_type]), headers=headers, media_type=media_type)


def choose(document: SessionDocument) -> SessionDocument:
    """Return the document with the target open that helps most, unlike those that the user did not want."""
    record = document.model_dump()
    rules = Capture.from_record(record)
    views, excluded = rules.board.views(record["views"]), exclusions(record["views"])
    skipped = tuple(guidance.TargetPose.from_dict(target) for target in document.skipped)
    unreached = tuple(guidance.TargetPose.from_dict(target) for target in document.unreached)
    target = rules.next_target(views, rules.estimate(views, excluded), skipped, unreached)
    return session_rules.with_target(document, target.to_record())


def draw(document: SessionDocument, image_format: Format) -> bytes:
    """Return the picture of the open target, through the session's current camera."""
    board, camera, target = drawn(document)
    return overlay.render(board, camera, target, image_format)


def drawn(document: SessionDocument) -> tuple[Board, Camera, guidance.TargetPose]:
    """Return the board, the session's current camera, and the open target as this camera sees it."""
    record = document.model_dump()
    rules = Capture.from_record(record)
    fit = document.estimate.fit
    camera = Camera.from_record(fit.model_dump()) if fit else rules.camera(None)
    excluded = exclusions(record["views"])
    views = [view for i, view in enumerate(rules.board.views(record["views"])) if i not in excluded]
    target = guidance.TargetPose.from_dict(document.target or {})
    return rules.board, camera, rules.redraw(target, views, camera)


handler = application.handler(application.route("/v1/session/pose", GET=show))
