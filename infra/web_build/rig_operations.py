"""The calls of the API about rigs."""

from __future__ import annotations

from calibdb import schema
from calibdb.schema.membership import MAX_MOMENT_LENGTH
from calibdb.schema.rig import RIG_FORMATS
from infra.web_build.operation import Content, Operation
from infra.web_build.parameters import SWITCH, Node, path, query

_SESSION = ("sessionId",)
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
        _SESSION,
        schema.RigRequest,
        problems=(404, 409),
        tag="Rigs",
        description=(
            "Creates a rig of two to eight cameras. The session, which has no views yet, is camera 0 and "
            "leads. Other cameras join with `POST /v1/session` and `rig: {code, position?}`, from any "
            "device. The code is valid for 15 minutes and until all cameras have joined; the same request "
            "again returns the same rig and a fresh code. The board must not look the same after half a "
            "turn. With `square_size` lengths are in metres."
        ),
        example={"cameras": 2, "square_size": 0.03},
    ),
    Operation(
        "get",
        "/v1/rigs/{id}",
        "showRig",
        "Cameras, moments, error, target and result of a rig",
        {200: _RIG_STATE, 304: Content("Nothing has changed since the state with the ETag sent.")},
        ("sessionId", "apiToken"),
        parameters=(_ID, query("skip", SWITCH, "`1`, of the leader: a target of another kind.")),
        problems=(404, 409, 422),
        tag="Rigs",
        description=(
            "Returns the state of a rig: its cameras, its moments and what is set aside of them, the "
            "expected error, and the next pose of the board as each camera sees it. Poll once a second "
            "with `If-None-Match`: 304 does not count against the plan."
        ),
        example_path={"id": "RIG_ID"},
    ),
    Operation(
        "delete",
        "/v1/rigs/{id}",
        "forgetRig",
        "Delete a running rig and its sessions",
        {204: Content("Forgotten.")},
        _SESSION,
        parameters=(_ID,),
        problems=(404, 409),
        tag="Rigs",
        description="Deletes a running rig with the sessions of its cameras. A finished rig stays.",
        example_path={"id": "RIG_ID"},
    ),
    Operation(
        "post",
        "/v1/rigs/{id}/moments",
        "openMoment",
        "Open a moment",
        {201: _RIG_STATE},
        _SESSION,
        schema.MomentRequest,
        parameters=(_ID,),
        problems=(404, 409),
        tag="Rigs",
        description=(
            "Opens a moment: one pose of the board, held still, under an id that the leader chooses. Each "
            "camera then sends its view of it with `POST /v1/session/views` and `moment`, at any later "
            "time. A rig has at most 100 moments."
        ),
        example={"moment": "m1"},
        example_path={"id": "RIG_ID"},
    ),
    Operation(
        "delete",
        "/v1/rigs/{id}/moments/{moment}",
        "undoMoment",
        "Undo a moment in all cameras",
        {200: _RIG_STATE},
        _SESSION,
        parameters=(_ID, _moment()),
        problems=(404, 409, 422),
        tag="Rigs",
        description="Undoes a moment. Its views are removed from all cameras, and late ones are refused.",
        example_path={"id": "RIG_ID", "moment": "m1"},
    ),
    Operation(
        "post",
        "/v1/rigs/{id}/finish",
        "finishRig",
        "End a rig and publish its result",
        {200: _RIG_STATE},
        _SESSION,
        parameters=(_ID,),
        problems=(404, 409),
        tag="Rigs",
        description=(
            "Ends a rig whose cameras are all linked and have four agreeing views. Each camera's session is "
            "published as a calibration; the rig contains their poses."
        ),
        example_path={"id": "RIG_ID"},
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
        ("apiToken", "sessionId"),
        parameters=(
            _ID,
            query(
                "format", {"type": "string", "enum": list(RIG_FORMATS)}, "File format; `json` unless given."
            ),
        ),
        problems=(404, 409, 422),
        tag="Rigs",
        description=(
            "Returns the cameras as they were fitted together, and the pose of each relative to camera 0. "
            "`format` chooses files of OpenCV (`opencv_stereo`), ROS, Kalibr, COLMAP, mrcal or glTF."
        ),
        example_path={"id": "RIG_ID"},
    ),
)
