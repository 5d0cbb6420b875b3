"""The calls of the API: requests, responses and problems, for `infra.web_build.openapi`.

Their descriptions are in `web/templates/docs/calls.md`.

In the example requests `SESSION_ID`, `MANAGEMENT_TOKEN`, `CALIBRATION_ID`, `RIG_ID` and `CAMERA_KEY` stand
for values from earlier responses. `infra.web_build.recorded_examples` sends the requests and records the
responses.
"""

from calibdb import schema
from calibdb.schema.cameras import CamerasRequest
from calibdb.schema.fields import MAX_INDEX
from calibdb.schema.membership import MAX_MOMENT_LENGTH
from calibdb.schema.rig import RIG_FORMATS
from calibdb.store.aliases import alias_digest
from infra.web_build.operation import (
    JPEG,
    JSON,
    PNG,
    PROBLEM,
    SVG,
    SWITCH,
    Content,
    Operation,
    path,
    query,
    query_of,
)

EXAMPLE_CAMERA = "HD Pro Webcam C920 (046d:082d)"
EXAMPLE_PLATFORM = "X11; Linux x86_64"
EXAMPLE_KEY = {"camera": EXAMPLE_CAMERA, "platform": EXAMPLE_PLATFORM, "img_size": [1280, 720]}
EXAMPLE_BOARD = {"squares": [9, 6], "marker_ratio": 0.65, "dictionary": "DICT_4X4_50", "legacy": False}
_VIEW = {
    "ids": [0, 1, 2, 8, 9, 10, 16],
    "points": [
        *([412.3, 207.9], [498.1, 214.0], [585.6, 220.7], [405.2, 291.4], [492.8, 298.9], [582.0, 306.8]),
        [398.0, 377.1],
    ],
}

EXAMPLE_FILE = (
    "image_width: 1280\nimage_height: 720\ncamera_name: c920\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [952.1, 0, 644.8, 0, 951.7, 358.2, 0, 0, 1]\ndistortion_model: plumb_bob\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.09, -0.19, 0.0004, -0.0007, 0.0]\n"
)
"""A file of ROS."""


_TEXTS = ("application/yaml", "application/xml", "text/plain")
_FILES = (*_TEXTS, "application/octet-stream", "model/gltf+json")
"""Media types of other tools' files."""
_LOOKUP = query_of(
    schema.LookupRequest,
    {
        "camera": "`MediaStreamTrack.label`",
        "platform": "The parenthesised part of the user agent.",
        "img_size": "Width and height, px.",
        "zoom": "`zoom` of the track.",
        "distortion_model": "The requested model.",
        "resize_mode": "`resizeMode` of the track.",
        "device": "Model identifier of the phone, `iPhone17,3`.",
        "redirect": "`false`: 404 with `guidance_url` instead of the redirect.",
        "miss": "`ok`: 200 with `calibration: null` instead of the redirect.",
    },
    deprecated=("userAgent", "imsize"),
    body_only=("reported", "board", "views"),
)
_REDIRECT = next(node for node in _LOOKUP if node["name"] == "redirect")
_CONVERSION = (
    "`X-Conversion-Error` says how many px its projection is off at most, `X-Conversion-Coverage` over which "
    "share of the image."
)
_STATE = Content("The session's state.", schema.SessionState)
_TOKEN, _SESSION, _MANAGEMENT = ("apiToken",), ("sessionId",), ("managementToken",)
_MANAGED_TOKEN = Content("All about the token.", schema.ManagedToken)
_FOUND = {
    200: Content(
        "The calibration; with `miss=ok` also that nothing reliable is known.",
        schema.LookupAnswer,
        other=schema.NoCalibration,
    ),
    307: Content("Nothing reliable is known: to the guidance page.", schema.Miss, headers=("Location",)),
    404: Content(
        "Nothing reliable is known, and `redirect=false`.", schema.LookupProblem, media_type=PROBLEM
    ),
}

_RIG_STATE = Content("The rig's state.", schema.RigState, headers=("ETag",))
_RIG_ID = path("id", "Id of the rig.")
_RIG_FILES = ("application/yaml", "application/zip", "model/gltf+json")
_MOMENT = path(
    "moment",
    "Id of the moment.",
    {"type": "string", "pattern": rf"^[A-Za-z0-9_-]{{1,{MAX_MOMENT_LENGTH}}}$"},
)

_RIGS = (
    Operation(
        "post",
        "/v1/rigs",
        "createRig",
        "Make a rig whose first camera is the session's; again gives a fresh join code",
        {201: Content("The rig, and the code by which other cameras join it.", schema.RigOpened)},
        _SESSION,
        schema.RigRequest,
        problems=(404, 409),
        example={"cameras": 2, "square_size": 0.03},
    ),
    Operation(
        "get",
        "/v1/rigs/{id}",
        "showRig",
        "Cameras, moments, error, target and result of a rig",
        {200: _RIG_STATE, 304: Content("Nothing has changed since the state with the ETag sent.")},
        ("sessionId", "apiToken"),
        parameters=(_RIG_ID, query("skip", SWITCH, "`1`, of the leader: a target of another kind.")),
        problems=(404, 409, 422),
    ),
    Operation(
        "delete",
        "/v1/rigs/{id}",
        "forgetRig",
        "Delete a running rig and its sessions",
        {204: Content("Forgotten.")},
        _SESSION,
        parameters=(_RIG_ID,),
        problems=(404, 409),
    ),
    Operation(
        "post",
        "/v1/rigs/{id}/moments",
        "openMoment",
        "Open a moment",
        {201: _RIG_STATE},
        _SESSION,
        schema.MomentRequest,
        parameters=(_RIG_ID,),
        problems=(404, 409),
        example={"moment": "m1"},
    ),
    Operation(
        "delete",
        "/v1/rigs/{id}/moments/{moment}",
        "undoMoment",
        "Undo a moment in all cameras",
        {200: _RIG_STATE},
        _SESSION,
        parameters=(_RIG_ID, _MOMENT),
        problems=(404, 409, 422),
        example_path={"moment": "m1"},
    ),
    Operation(
        "post",
        "/v1/rigs/{id}/finish",
        "finishRig",
        "End a rig and publish its result",
        {200: _RIG_STATE},
        _SESSION,
        parameters=(_RIG_ID,),
        problems=(404, 409),
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
            _RIG_ID,
            query(
                "format", {"type": "string", "enum": list(RIG_FORMATS)}, "File format; `json` unless given."
            ),
        ),
        problems=(404, 409, 422),
    ),
)

_TOKENS = (
    Operation(
        "post",
        "/v1/tokens",
        "createToken",
        "Make an API token for pages of some origins, and for programs",
        {201: Content("The token. Its two secrets are shown this once.", schema.TokenCreated)},
        body=schema.TokenRequest,
        problems=(403, 415, 429),
        example={"origins": ["http://localhost", "https://page.example"], "name": "My page"},
    ),
    Operation(
        "get",
        "/v1/tokens/self",
        "showToken",
        "Facts about a token, its limits, and its use by hour and day",
        {200: _MANAGED_TOKEN},
        _MANAGEMENT,
    ),
    Operation(
        "patch",
        "/v1/tokens/self",
        "changeToken",
        "Give a token other origins or another name",
        {200: _MANAGED_TOKEN},
        _MANAGEMENT,
        schema.TokenChange,
        example={"origins": ["http://localhost", "https://www.page.example"]},
    ),
    Operation(
        "delete",
        "/v1/tokens/self",
        "revokeToken",
        "Revoke a token for good, within a minute",
        {204: Content("Revoked.")},
        _MANAGEMENT,
    ),
    Operation(
        "post",
        "/v1/tokens/self/verify",
        "verifyToken",
        "Look for the proofs of the origins that are pending",
        {200: _MANAGED_TOKEN},
        _MANAGEMENT,
    ),
    Operation(
        "post",
        "/v1/tokens/self/rotate",
        "rotateToken",
        "Give a token another secret; without a body the one until now opens for a day more",
        {200: Content("The token with its new secret, shown this once.", schema.TokenRotated)},
        _MANAGEMENT,
        schema.RotationRequest,
        body_required=False,
        example={"grace_s": 3600},
    ),
    Operation(
        "get",
        "/v1/usage",
        "showUsage",
        "Limits and use of an API token in this hour",
        {200: Content("Limits and use.", schema.UsageAnswer)},
        _TOKEN,
    ),
)

OPERATIONS = (
    Operation(
        "post",
        "/v1/auth",
        "openSession",
        "Exchange an API token for the credential of one guided capture",
        {201: Content("A session id, signed and short-lived.", schema.SessionOpened)},
        _TOKEN,
    ),
    Operation(
        "post",
        "/v1/session",
        "startSession",
        "Start a guided capture",
        {201: _STATE},
        _SESSION,
        schema.SessionRequest,
        problems=(409,),
        example={**EXAMPLE_KEY, "board": EXAMPLE_BOARD},
    ),
    Operation(
        "get",
        "/v1/session",
        "showSession",
        "State of a capture",
        {200: _STATE},
        _SESSION,
        problems=(404,),
    ),
    Operation(
        "delete",
        "/v1/session",
        "forgetSession",
        "Delete a session and its views",
        {204: Content("Forgotten.")},
        _SESSION,
        problems=(404, 409),
    ),
    Operation(
        "get",
        "/v1/session/pose",
        "showPose",
        "Target pose of the board",
        {
            200: Content(
                "The board as the camera would see it there, black elsewhere; or the same in numbers.",
                schema.Pose,
                (JPEG, PNG),
            )
        },
        _SESSION,
        parameters=(query("skip", SWITCH, "`1`: a pose of another kind instead of the open one."),),
        problems=(404, 406, 409, 422),
        example_accept="application/json",
    ),
    Operation(
        "post",
        "/v1/session/views",
        "submitView",
        "Submit a view: the corners in one frame",
        {200: Content("The session's state, and whether the view is part of it.", schema.ViewAnswer)},
        _SESSION,
        schema.ViewRequest,
        problems=(404, 409),
        example={"index": 0, **_VIEW},
    ),
    Operation(
        "post",
        "/v1/session/batch",
        "submitViews",
        "Submit several views of a recorded session; each has a result",
        {200: Content("The session's state, and the results of the views.", schema.BatchAnswer)},
        _SESSION,
        schema.BatchRequest,
        problems=(404, 409),
        example={"index": 0, "views": [_VIEW]},
    ),
    Operation(
        "delete",
        "/v1/session/views/{index}",
        "undoView",
        "Undo a view",
        {200: _STATE},
        _SESSION,
        parameters=(
            path("index", "Index of the view.", {"type": "integer", "minimum": 0, "maximum": MAX_INDEX}),
        ),
        problems=(404, 409, 422),
        example_path={"index": "0"},
    ),
    Operation(
        "post",
        "/v1/session/finish",
        "finishSession",
        "End a session with the views that agree",
        {200: _STATE},
        _SESSION,
        problems=(404, 409),
    ),
    Operation(
        "post",
        "/v1/session/licence",
        "licenseSession",
        "Add a licence to the views of a session",
        {200: _STATE},
        _SESSION,
        schema.LicenceRequest,
        problems=(404, 409),
        example={"licence": "CC0-1.0", "licence_version": "2026-11-22"},
    ),
    Operation(
        "post",
        "/v1/lookup",
        "lookup",
        "The calibration of a camera",
        _FOUND,
        _TOKEN,
        schema.LookupRequest,
        (_REDIRECT,),
        example={**EXAMPLE_KEY, "zoom": 0, "miss": "ok"},
    ),
    Operation(
        "get",
        "/v1/lookup",
        "visitLookup",
        "The calibration of a camera, or a navigation to the guidance page",
        _FOUND,
        ("apiToken", "apiTokenInQuery", "apiTokenInOldQuery"),
        parameters=_LOOKUP,
        problems=(422,),
        example_query={
            "camera": EXAMPLE_CAMERA,
            "platform": EXAMPLE_PLATFORM,
            "img_size": "1280x720",
            "redirect": "false",
        },
    ),
    Operation(
        "get",
        "/v1/calibrations/{id}",
        "showCalibration",
        "One stored calibration or consensus",
        {
            200: Content(
                "The calibration, and what its session found out about it; or another tool's file. "
                + _CONVERSION,
                schema.ReportedCalibration,
                _FILES,
                headers=("X-Conversion-Error", "X-Conversion-Coverage"),
                sometimes=("Content-Disposition", "X-Conversion-Warning"),
            )
        },
        _TOKEN,
        parameters=(
            path("id", "As a session or a lookup returned it."),
            *query_of(schema.ExportQuery),
        ),
        problems=(404, 410, 422),
    ),
    Operation(
        "post",
        "/v1/convert",
        "convertFile",
        "Another program's calibration file in another format",
        {
            200: Content(
                "The file. Its camera matrix and distortion are read, and nothing is stored. " + _CONVERSION,
                None,
                (JSON, *_FILES),
                headers=("X-Conversion-Error", "X-Conversion-Coverage", "Content-Disposition"),
                sometimes=("X-Conversion-Warning",),
            )
        },
        _TOKEN,
        body=schema.ConvertRequest,
        example={"file": EXAMPLE_FILE, "format": "kalibr"},
    ),
    Operation(
        "post",
        "/v1/checks",
        "checkCalibration",
        "Check a consensus or a calibration against fresh views",
        {
            200: Content(
                "Result of the check and the votes so far, or the comparison of `calibration`.",
                schema.CheckAnswer,
                other=schema.ComparisonAnswer,
            )
        },
        _SESSION,
        schema.CheckRequest,
        problems=(404,),
        example={**EXAMPLE_KEY, "views": [_VIEW]},
    ),
    Operation(
        "get",
        "/v1/cameras",
        "searchCameras",
        "Search cameras by name",
        {200: Content("The cameras found.", schema.CameraList)},
        _TOKEN,
        parameters=query_of(CamerasRequest),
        problems=(422,),
        example_query={"query": "c920"},
    ),
    Operation(
        "get",
        "/v1/cameras/{key}",
        "showCamera",
        "Everything about one camera",
        {200: Content("The camera, by size and zoom.", schema.CameraDetail)},
        _TOKEN,
        parameters=(path("key", "As a search returned it."),),
        problems=(404,),
    ),
    Operation(
        "get",
        "/known/v1/{digest}/{size}/{zoom}/{file}",
        "lookupKnown",
        "Cacheable lookup of a known camera",
        {
            200: Content("The calibration.", schema.LookupAnswer, headers=("ETag",)),
            404: Content("Ask by POST.", schema.UnknownCamera),
        },
        parameters=(
            path("digest", "Of label and platform: docs/api.md, Known cameras."),
            path("size", "Width, x and height of the image, as in `1280x720`."),
            path("zoom", "Up to six decimals, without zeros at the end: `0`, `1.5`."),
            path("file", "Distortion model and `.json`, as in `rectilinear.json`."),
        ),
        example_path={
            "digest": alias_digest(EXAMPLE_CAMERA, EXAMPLE_PLATFORM),
            "size": "1280x720",
            "zoom": "0",
            "file": "rectilinear.json",
        },
    ),
    Operation(
        "get",
        "/badge/{key}/{file}",
        "showBadge",
        "Badge for a README",
        {200: Content("The badge; a grey one where nothing is known.", pictures=(SVG,))},
        parameters=(
            path("key", "As a search returned it."),
            path("file", "Width, x, height and `.svg`, as in `1280x720.svg`."),
        ),
        example_path={"file": "1280x720.svg"},
    ),
    *_RIGS,
    *_TOKENS,
    Operation(
        "get",
        "/healthz",
        "health",
        "State of the service",
        {
            200: Content("It is; with `deep=1`, so is every part.", schema.Health, other=schema.DeepHealth),
            503: Content("With `deep=1`: some part does not work.", schema.HealthProblem, media_type=PROBLEM),
        },
        parameters=(
            query("deep", SWITCH, "`1`: check table, bucket, edge and solver, each with its latency."),
        ),
        problems=(422,),
    ),
)
