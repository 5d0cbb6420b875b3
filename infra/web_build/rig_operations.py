"""The calls of the API about rigs."""

from __future__ import annotations

from calibdb import schema
from calibdb.schema.membership import MAX_MOMENT_LENGTH
from calibdb.schema.rig import RIG_FORMATS
from infra.web_build.operation import Content, Operation
from infra.web_build.parameters import SWITCH, Node, path, query

_SESSION = ("sessionId",)
_ASKED = (401, 403, 429, 500, 503)
_RIG_STATE = Content("The rig's state.", schema.RigState, headers=("ETag",))
_ID = path("id", {"type": "string"}, "Id of the rig.")
_RIG_FILES = ("application/yaml", "application/zip", "model/gltf+json")


def _moment() -> Node:
    schema_of_id: Node = {"type": "string", "pattern": rf"^[A-Za-z0-9_-]{{1,{MAX_MOMENT_LENGTH}}}$"}
    return path("moment", schema_of_id, "Id of the moment.")


RIG_OPERATIONS = (
    Operation(
        "post",
        "/v1/rigs",
        "createRig",
        "Make a rig whose first camera is the session's; again gives a fresh join code",
        {201: Content("The rig, and the code by which other cameras join it.", schema.RigOpened)},
        (400, *_ASKED, 404, 409, 413, 422),
        _SESSION,
        schema.RigRequest,
    ),
    Operation(
        "get",
        "/v1/rigs/{id}",
        "showRig",
        "Cameras, moments, error, target and result of a rig",
        {200: _RIG_STATE, 304: Content("Nothing has changed since the state with the ETag sent.")},
        (*_ASKED, 404, 409, 422),
        ("sessionId", "apiToken"),
        parameters=(_ID, query("skip", SWITCH, "`1`, of the leader: a target of another kind.")),
    ),
    Operation(
        "delete",
        "/v1/rigs/{id}",
        "forgetRig",
        "Delete a running rig and its sessions",
        {204: Content("Forgotten.")},
        (*_ASKED, 404, 409),
        _SESSION,
        parameters=(_ID,),
    ),
    Operation(
        "post",
        "/v1/rigs/{id}/moments",
        "openMoment",
        "Open a moment",
        {201: _RIG_STATE},
        (400, *_ASKED, 404, 409, 413, 422),
        _SESSION,
        schema.MomentRequest,
        parameters=(_ID,),
    ),
    Operation(
        "delete",
        "/v1/rigs/{id}/moments/{moment}",
        "undoMoment",
        "Undo a moment in all cameras",
        {200: _RIG_STATE},
        (*_ASKED, 404, 409, 422),
        _SESSION,
        parameters=(_ID, _moment()),
    ),
    Operation(
        "post",
        "/v1/rigs/{id}/finish",
        "finishRig",
        "End a rig and publish its result",
        {200: _RIG_STATE},
        (*_ASKED, 404, 409),
        _SESSION,
        parameters=(_ID,),
    ),
    Operation(
        "get",
        "/v1/rigs/{id}/result",
        "showRigResult",
        "Result of a finished rig, or another tool's files of it",
        {
            200: Content(
                "Cameras and where they are; several files come as one ZIP archive.",
                schema.RigResult,
                _RIG_FILES,
                sometimes=("Content-Disposition", "X-Conversion-Error", "X-Conversion-Warning"),
            )
        },
        (*_ASKED, 404, 409, 422),
        ("apiToken", "sessionId"),
        parameters=(
            _ID,
            query(
                "format", {"type": "string", "enum": list(RIG_FORMATS)}, "File format; `json` unless given."
            ),
        ),
    ),
)
