"""The calls of the API: requests, responses and problems, for `infra.web_build.openapi`."""

from __future__ import annotations

from calibdb import schema
from calibdb.schema.cameras import CamerasRequest
from calibdb.schema.fields import MAX_INDEX
from infra.web_build.operation import JPEG, JSON, PNG, PROBLEM, SVG, Content, Operation
from infra.web_build.parameters import SWITCH, path, query, query_of
from infra.web_build.rig_operations import RIG_OPERATIONS

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
_STATE = Content("The session's state.", schema.SessionState)
_TOKEN, _SESSION, _MANAGEMENT = ("apiToken",), ("sessionId",), ("managementToken",)
_MANAGED_TOKEN = Content("All about the token.", schema.ManagedToken)
_ASKED = (401, 403, 429, 500, 503)
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

_TOKENS = (
    Operation(
        "post",
        "/v1/tokens",
        "createToken",
        "Make an API token for pages of some origins, and for programs",
        {201: Content("The token. Its two secrets are shown this once.", schema.TokenCreated)},
        (400, 403, 413, 415, 422, 429, 500, 503),
        body=schema.TokenRequest,
    ),
    Operation(
        "get",
        "/v1/tokens/self",
        "showToken",
        "Facts about a token, its limits, and its use by hour and day",
        {200: _MANAGED_TOKEN},
        _ASKED,
        _MANAGEMENT,
    ),
    Operation(
        "patch",
        "/v1/tokens/self",
        "changeToken",
        "Give a token other origins or another name",
        {200: _MANAGED_TOKEN},
        (400, *_ASKED, 413, 422),
        _MANAGEMENT,
        schema.TokenChange,
    ),
    Operation(
        "delete",
        "/v1/tokens/self",
        "revokeToken",
        "Revoke a token for good, within a minute",
        {204: Content("Revoked.")},
        _ASKED,
        _MANAGEMENT,
    ),
    Operation(
        "post",
        "/v1/tokens/self/verify",
        "verifyToken",
        "Look for the proofs of the origins that are pending",
        {200: _MANAGED_TOKEN},
        _ASKED,
        _MANAGEMENT,
    ),
    Operation(
        "post",
        "/v1/tokens/self/rotate",
        "rotateToken",
        "Give a token another secret; without a body the one until now opens for a day more",
        {200: Content("The token with its new secret, shown this once.", schema.TokenRotated)},
        (400, *_ASKED, 413, 422),
        _MANAGEMENT,
        schema.RotationRequest,
        body_required=False,
    ),
    Operation(
        "get",
        "/v1/usage",
        "showUsage",
        "Limits and use of an API token in this hour",
        {200: Content("Limits and use.", schema.UsageAnswer)},
        _ASKED,
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
        _ASKED,
        _TOKEN,
    ),
    Operation(
        "post",
        "/v1/session",
        "startSession",
        "Start a guided capture",
        {201: _STATE},
        (400, *_ASKED, 409, 413, 422),
        _SESSION,
        schema.SessionRequest,
    ),
    Operation(
        "get", "/v1/session", "showSession", "State of a capture", {200: _STATE}, (*_ASKED, 404), _SESSION
    ),
    Operation(
        "delete",
        "/v1/session",
        "forgetSession",
        "Delete a session and its views",
        {204: Content("Forgotten.")},
        (*_ASKED, 404, 409),
        _SESSION,
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
        (*_ASKED, 404, 406, 409, 422),
        _SESSION,
        parameters=(query("skip", SWITCH, "`1`: a pose of another kind instead of the open one."),),
    ),
    Operation(
        "post",
        "/v1/session/views",
        "submitView",
        "Submit a view: the corners in one frame",
        {200: Content("The session's state, and whether the view is part of it.", schema.ViewAnswer)},
        (400, *_ASKED, 404, 409, 413, 422),
        _SESSION,
        schema.ViewRequest,
    ),
    Operation(
        "post",
        "/v1/session/batch",
        "submitViews",
        "Submit several views of a recorded session; each has a result",
        {200: Content("The session's state, and the results of the views.", schema.BatchAnswer)},
        (400, *_ASKED, 404, 409, 413, 422),
        _SESSION,
        schema.BatchRequest,
    ),
    Operation(
        "delete",
        "/v1/session/views/{index}",
        "undoView",
        "Undo a view",
        {200: _STATE},
        (*_ASKED, 404, 409, 422),
        _SESSION,
        parameters=(
            path("index", {"type": "integer", "minimum": 0, "maximum": MAX_INDEX}, "Index of the view."),
        ),
    ),
    Operation(
        "post",
        "/v1/session/finish",
        "finishSession",
        "End a session with the views that agree",
        {200: _STATE},
        (*_ASKED, 404, 409),
        _SESSION,
    ),
    Operation(
        "post",
        "/v1/session/licence",
        "licenseSession",
        "Add a licence to the views of a session",
        {200: _STATE},
        (400, *_ASKED, 404, 409, 413, 422),
        _SESSION,
        schema.LicenceRequest,
    ),
    Operation(
        "post",
        "/v1/lookup",
        "lookup",
        "The calibration of a camera",
        _FOUND,
        (400, *_ASKED, 413, 422),
        _TOKEN,
        schema.LookupRequest,
        (_REDIRECT,),
    ),
    Operation(
        "get",
        "/v1/lookup",
        "visitLookup",
        "The calibration of a camera, or a navigation to the guidance page",
        _FOUND,
        (*_ASKED, 422),
        ("apiToken", "apiTokenInQuery", "apiTokenInOldQuery"),
        parameters=_LOOKUP,
    ),
    Operation(
        "get",
        "/v1/calibrations/{id}",
        "showCalibration",
        "One stored calibration or consensus",
        {
            200: Content(
                "The calibration, and what its session found out about it; or another tool's file. "
                "`X-Conversion-Error` says how many px its projection is off at most, "
                "`X-Conversion-Coverage` over which share of the image.",
                schema.ReportedCalibration,
                _FILES,
                headers=("X-Conversion-Error", "X-Conversion-Coverage"),
                sometimes=("Content-Disposition", "X-Conversion-Warning"),
            )
        },
        (*_ASKED, 404, 410, 422),
        _TOKEN,
        parameters=(
            path("id", {"type": "string"}, "As a session or a lookup returned it."),
            *query_of(schema.ExportQuery),
        ),
    ),
    Operation(
        "post",
        "/v1/convert",
        "convertFile",
        "Another program's calibration file in another format",
        {
            200: Content(
                "The file. Its camera matrix and distortion are read, and nothing is stored. "
                "`X-Conversion-Error` says how many px its projection is off at most, "
                "`X-Conversion-Coverage` over which share of the image.",
                None,
                (JSON, *_FILES),
                headers=("X-Conversion-Error", "X-Conversion-Coverage", "Content-Disposition"),
                sometimes=("X-Conversion-Warning",),
            )
        },
        (400, *_ASKED, 413, 422),
        _TOKEN,
        body=schema.ConvertRequest,
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
        (400, *_ASKED, 404, 413, 422),
        _SESSION,
        schema.CheckRequest,
    ),
    Operation(
        "get",
        "/v1/cameras",
        "searchCameras",
        "Search cameras by name",
        {200: Content("The cameras found.", schema.CameraList)},
        (*_ASKED, 422),
        _TOKEN,
        parameters=query_of(CamerasRequest),
    ),
    Operation(
        "get",
        "/v1/cameras/{key}",
        "showCamera",
        "Everything about one camera",
        {200: Content("The camera, by size and zoom.", schema.CameraDetail)},
        (*_ASKED, 404),
        _TOKEN,
        parameters=(path("key", {"type": "string"}, "As a search returned it."),),
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
        (500, 503),
        parameters=(
            path("digest", {"type": "string"}, "Of label and platform: docs/api.md, Known cameras."),
            path("size", {"type": "string"}, "Width, x and height of the image, as in `1280x720`."),
            path("zoom", {"type": "string"}, "Up to six decimals, without zeros at the end: `0`, `1.5`."),
            path("file", {"type": "string"}, "Distortion model and `.json`, as in `rectilinear.json`."),
        ),
    ),
    Operation(
        "get",
        "/badge/{key}/{file}",
        "showBadge",
        "Badge for a README",
        {200: Content("The badge; a grey one where nothing is known.", pictures=(SVG,))},
        (500, 503),
        parameters=(
            path("key", {"type": "string"}, "As a search returned it."),
            path("file", {"type": "string"}, "Width, x, height and `.svg`, as in `1280x720.svg`."),
        ),
    ),
    *RIG_OPERATIONS,
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
        (422, 500),
        parameters=(
            query("deep", SWITCH, "`1`: check table, bucket, edge and solver, each with its latency."),
        ),
    ),
)
