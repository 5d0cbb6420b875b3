"""Group, description and example of every call, by the names in `infra.web_build.operations`.

`SESSION_ID`, `MANAGEMENT_TOKEN`, `CALIBRATION_ID`, `RIG_ID` and `CAMERA_KEY` in the examples stand for
results of earlier calls. `infra.web_build.recorded_examples` sends the examples and records the responses.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from calibdb.store.aliases import alias_digest

TAGS = {
    "Lookup": "Find the calibration of a camera.",
    "Capture": "Calibrate a camera, view by view. The guidance page makes these calls; any client can.",
    "Rigs": "Calibrate several fixed cameras together, each from its own client.",
    "Database": "Search cameras, read stored calibrations, write them as another tool's file.",
    "Tokens": "Create and manage API tokens. Anyone can create one.",
    "Service": "State of the service.",
}
"""Groups of calls, in the order of the reference."""

EXAMPLE_CAMERA = "HD Pro Webcam C920 (046d:082d)"
EXAMPLE_PLATFORM = "X11; Linux x86_64"
_EXAMPLE_KEY = {"camera": EXAMPLE_CAMERA, "platform": EXAMPLE_PLATFORM, "img_size": [1280, 720]}
_BOARD = {"squares": [9, 6], "marker_ratio": 0.65, "dictionary": "DICT_4X4_50", "legacy": False}
EXAMPLE_IDS = [0, 1, 2, 8, 9, 10, 16]
EXAMPLE_POINTS = [
    *([412.3, 207.9], [498.1, 214.0], [585.6, 220.7], [405.2, 291.4], [492.8, 298.9], [582.0, 306.8]),
    [398.0, 377.1],
]

EXAMPLE_FILE = (
    "image_width: 1280\nimage_height: 720\ncamera_name: c920\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
    "  data: [952.1, 0, 644.8, 0, 951.7, 358.2, 0, 0, 1]\ndistortion_model: plumb_bob\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0.09, -0.19, 0.0004, -0.0007, 0.0]\n"
)
"""A file of ROS."""


@dataclass(frozen=True)
class OperationText:
    """Texts about one call.

    Attributes
    ----------
    tag
        Its group, one of `TAGS`.
    description
        Effect of the call, in a paragraph or two.
    body, query, path, accept
        Example of a request: body, query parameters, path parameters, media type.
    """

    tag: str
    description: str
    body: Any = None
    query: Mapping[str, str] = field(default_factory=dict)
    path: Mapping[str, str] = field(default_factory=dict)
    accept: str | None = None


TEXTS: dict[str, OperationText] = {
    "lookup": OperationText(
        "Lookup",
        "Returns the calibration of a camera: its camera matrix, its distortion, and how far to trust them. "
        "Name the camera as the browser does. If nothing reliable is known, "
        '`miss: "ok"` returns 200 with `calibration: null`, the `reason`, an `estimate`, and the '
        "`guidance_url` of the page that calibrates the camera. `redirect: false` returns 404 with the same. "
        "Otherwise the response is a redirect to that page, which `fetch()` cannot read.",
        {**_EXAMPLE_KEY, "zoom": 0, "miss": "ok"},
    ),
    "visitLookup": OperationText(
        "Lookup",
        "Same as `POST /v1/lookup`, with the names as query parameters. A browser can "
        "navigate to it with the API token in `key`. If nothing reliable is known, it is redirected to the "
        "guidance page.",
        query={
            "camera": EXAMPLE_CAMERA,
            "platform": EXAMPLE_PLATFORM,
            "img_size": "1280x720",
            "redirect": "false",
        },
    ),
    "openSession": OperationText(
        "Capture",
        "Exchanges an API token for a session id, the signed credential of one guided capture. "
        "It is valid for 30 minutes. All calls of that capture use it instead of the token.",
    ),
    "startSession": OperationText(
        "Capture",
        'Starts the capture of one camera at one size and zoom. Use `capture: "recorded"` for '
        "views that exist already: photos, a video, or another program's corners. Then every agreeing view "
        "counts, and `POST /v1/session/finish` ends the session. The call is idempotent; different content "
        "is 409.",
        {**_EXAMPLE_KEY, "board": _BOARD},
    ),
    "showSession": OperationText(
        "Capture",
        "Returns the session's state: its views, its progress, the current calibration and its expected "
        "error.",
    ),
    "licenseSession": OperationText(
        "Capture",
        "Adds the licence to a session and to the calibration that it published. A licence cannot be "
        "withdrawn or replaced.",
        {"licence": "CC0-1.0", "licence_version": "2026-11-22"},
    ),
    "forgetSession": OperationText(
        "Capture",
        "Ends the session and deletes its views. A published calibration stays.",
    ),
    "showPose": OperationText(
        "Capture",
        "Returns the target pose of the board, which stays the same until a view answers it. `Accept` "
        "chooses between an image to lay over the video (JPEG, PNG) and numbers. 409 once the session has "
        "converged.",
        accept="application/json",
    ),
    "submitView": OperationText(
        "Capture",
        "Submits the board's corners in one frame: their ids, and their positions in px, where "
        "the centre of the top-left pixel is (0, 0). At least six, not all on a line. `accepted` "
        "is true if the view became part of the session; otherwise `reason` explains the refusal. "
        "The call is idempotent.",
        {"index": 0, "ids": EXAMPLE_IDS, "points": EXAMPLE_POINTS},
    ),
    "submitViews": OperationText(
        "Capture",
        "Submits several views of a session that was started with `capture: recorded`. The service judges "
        "them in their order and returns a result for each. If a view has invalid fields, no view is judged, "
        "and `errors` has an entry for each invalid view.",
        {"index": 0, "views": [{"ids": EXAMPLE_IDS, "points": EXAMPLE_POINTS}]},
    ),
    "undoView": OperationText(
        "Capture",
        "Removes a view from the session. Its index is not used again.",
        path={"index": "0"},
    ),
    "finishSession": OperationText(
        "Capture",
        "Ends a session with the views that agree, publishes the calibration, and returns the state. "
        "At least four views must agree. The call is idempotent.",
    ),
    "checkCalibration": OperationText(
        "Capture",
        "Compares the stored consensus of a camera with one to five fresh views, and counts the "
        "result as a vote. Only the poses are fitted to the views. With `calibration` it compares that "
        "calibration with a fit of the views instead, without a vote. The session need not be started.",
        {**_EXAMPLE_KEY, "views": [{"ids": EXAMPLE_IDS, "points": EXAMPLE_POINTS}]},
    ),
    "showCalibration": OperationText(
        "Database",
        "Returns a stored calibration with the report of its session, or a consensus. `format` returns "
        "another tool's file; `crop`, `resize`, `rotate` and `mirror` convert it to a changed image. "
        "`without` refits the calibration without some views and stores nothing.",
        path={"id": "CALIBRATION_ID"},
    ),
    "convertFile": OperationText(
        "Database",
        "Reads the camera matrix and distortion of another program's file (OpenCV, ROS, Kalibr, COLMAP, "
        "mrcal, Gyroflow and others) and returns the file in `format`. Nothing is stored. Files above "
        "100,000 characters are refused. Only `photonvision` keeps the corners of a file.",
        body={"file": EXAMPLE_FILE, "format": "kalibr"},
    ),
    "searchCameras": OperationText(
        "Database",
        "Finds cameras by name: each word of `query` must begin a word of the name. "
        "Without a query it lists all cameras. Pass `next` as `after` for the following page.",
        query={"query": "c920"},
    ),
    "showCamera": OperationText(
        "Database",
        "Returns everything that is known about a camera: by size and zoom, the calibrations, "
        "the groups in which they agree, and the consensus of each model.",
        path={"key": "CAMERA_KEY"},
    ),
    "lookupKnown": OperationText(
        "Lookup",
        "Looks a camera up by the digest of its label and platform. It needs neither a credential nor a "
        "preflight, and caches keep the response. Ask here first, and by POST after a 404.",
        path={
            "digest": alias_digest(EXAMPLE_CAMERA, EXAMPLE_PLATFORM),
            "size": "1280x720",
            "zoom": "0",
            "file": "rectilinear.json",
        },
    ),
    "showBadge": OperationText(
        "Database",
        "Returns an image for a README or a page: whether a camera is calibrated at a size, and with "
        "which error. It needs no credential.",
        path={"key": "CAMERA_KEY", "file": "1280x720.svg"},
    ),
    "createToken": OperationText(
        "Tokens",
        "Creates an API token for pages of some origins, and for programs. Origins of the machine itself, "
        "such as `http://localhost`, need no proof. For an `https://` origin the response contains the "
        "proof to "
        "place there. The token and its management token are shown only once. One source can create five "
        "per day.",
        {"origins": ["http://localhost", "https://page.example"], "name": "My page"},
    ),
    "showToken": OperationText(
        "Tokens",
        "Returns the facts about a token, its limits, and its use by hour for two days and "
        "by day for thirty.",
    ),
    "changeToken": OperationText(
        "Tokens",
        "Replaces the origins or the name of a token. Origins that stay keep their state.",
        {"origins": ["http://localhost", "https://www.page.example"]},
    ),
    "revokeToken": OperationText(
        "Tokens",
        "Revokes a token for good, within a minute. The call is idempotent.",
    ),
    "verifyToken": OperationText(
        "Tokens",
        "Looks for the proofs of all pending origins, at `https://<origin>/.well-known/calibdb.txt`. "
        "`failure` and `detail` of an origin explain what is missing.",
    ),
    "rotateToken": OperationText(
        "Tokens",
        "Issues another secret, which is shown only once. The previous one works for another day, "
        "or for `grace_s` seconds; 0 ends all earlier secrets.",
        {"grace_s": 3600},
    ),
    "showUsage": OperationText(
        "Tokens",
        "Returns the limits of an API token's plan, and its use in this hour by all users and "
        "from your address. It counts as a lookup.",
    ),
    "createRig": OperationText(
        "Rigs",
        "Creates a rig of two to eight cameras. The session, which has no views yet, is camera 0 and leads. "
        "Other cameras join with `POST /v1/session` and `rig: {code, position?}`, from any device. The code "
        "is valid for 15 minutes and until all cameras have joined; the same request again returns the same "
        "rig and a fresh code. The board must not look the same after half a turn. With `square_size` "
        "lengths are in metres.",
        {"cameras": 2, "square_size": 0.03},
    ),
    "openMoment": OperationText(
        "Rigs",
        "Opens a moment: one pose of the board, held still, under an id that the leader chooses. Each camera "
        "then sends its view of it with `POST /v1/session/views` and `moment`, at any later time. A rig has "
        "at most 100 moments.",
        {"moment": "m1"},
        path={"id": "RIG_ID"},
    ),
    "showRig": OperationText(
        "Rigs",
        "Returns the state of a rig: its cameras, its moments and what is set aside of them, the expected "
        "error, and the next pose of the board as each camera sees it. Poll once a second with "
        "`If-None-Match`: 304 does not count against the plan.",
        path={"id": "RIG_ID"},
    ),
    "undoMoment": OperationText(
        "Rigs",
        "Undoes a moment. Its views are removed from all cameras, and late ones are refused.",
        path={"id": "RIG_ID", "moment": "m1"},
    ),
    "forgetRig": OperationText(
        "Rigs",
        "Deletes a running rig with the sessions of its cameras. A finished rig stays.",
        path={"id": "RIG_ID"},
    ),
    "finishRig": OperationText(
        "Rigs",
        "Ends a rig whose cameras are all linked and have four agreeing views. Each camera's session is "
        "published as a calibration; the rig contains their poses.",
        path={"id": "RIG_ID"},
    ),
    "showRigResult": OperationText(
        "Rigs",
        "Returns the cameras as they were fitted together, and the pose of each relative to camera 0. "
        "`format` chooses files of OpenCV (`opencv_stereo`), ROS, Kalibr, COLMAP, mrcal or glTF.",
        path={"id": "RIG_ID"},
    ),
    "health": OperationText(
        "Service",
        "Returns 200 if the service works. It needs no credential.",
    ),
}


def text_of(name: str) -> OperationText:
    """Return the texts of a call; ValueError if they are missing."""
    if name not in TEXTS:
        raise ValueError(f"infra/web_build/operation_texts.py has no text or example of {name}")
    return TEXTS[name]
