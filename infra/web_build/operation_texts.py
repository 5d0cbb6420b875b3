"""Group, description and example of every call, by the names in `infra.web_build.operations`.

Examples are requests as somebody sends them. `SESSION_ID`, `MANAGEMENT_TOKEN`, `CALIBRATION_ID`, `RIG_ID` and
`CAMERA_KEY` stand for what an earlier call answered.
`infra.web_build.recorded_examples` sends them and records the answers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from calibdb.store.aliases import alias_digest

TAGS = {
    "Lookup": "Find the calibration of a camera.",
    "Capture": "Calibrate a camera, view by view. The guidance page makes these calls; any client can.",
    "Rigs": "Calibrate cameras that do not move against each other together, each from a client of its own.",
    "Database": "Search cameras, read stored calibrations, write them as another tool's file.",
    "Tokens": "Make and manage API tokens. Nobody has to be asked for one.",
    "Service": "Whether the service is there.",
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
    """Words about one call.

    Attributes
    ----------
    tag
        Its group, one of `TAGS`.
    description
        What it does, in a paragraph or two.
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
        "Answers with the calibration of a camera: its camera matrix, its distortion, and how far "
        "to trust them. Name the camera as the browser does. Where nothing reliable is known, "
        '`miss: "ok"` answers 200 with `calibration: null`, the `reason`, an `estimate`, and the '
        "`guidance_url` where the camera can be calibrated; `redirect: false` answers 404 with the same; "
        "without either the answer is a redirect to that page, which `fetch()` cannot read.",
        {**_EXAMPLE_KEY, "zoom": 0, "miss": "ok"},
    ),
    "visitLookup": OperationText(
        "Lookup",
        "The same as `POST /v1/lookup`, with the names as query parameters. A browser can "
        "navigate to it with the API token in `key`, and is redirected to the guidance page where "
        "nothing reliable is known.",
        query={
            "camera": EXAMPLE_CAMERA,
            "platform": EXAMPLE_PLATFORM,
            "img_size": "1280x720",
            "redirect": "false",
        },
    ),
    "openSession": OperationText(
        "Capture",
        "Exchanges an API token for a session id: the credential of one guided capture, signed, "
        "and good for 30 minutes. All calls of that capture carry it instead of the token.",
    ),
    "startSession": OperationText(
        "Capture",
        'Starts the capture of one camera at one size and zoom. `capture: "recorded"` is for '
        "views that are all there already (photographs, a video, another program's corners): then "
        "every view that agrees counts, and `POST /v1/session/finish` ends the session. The same "
        "content again is answered again; other content is 409.",
        {**_EXAMPLE_KEY, "board": _BOARD},
    ),
    "showSession": OperationText(
        "Capture",
        "Answers with the session's state: its views, its progress, the calibration so far and "
        "the error that it expects.",
    ),
    "licenseSession": OperationText(
        "Capture",
        "Adds the licence to a session and to the calibration that it published. A licence cannot be "
        "taken back or replaced: a session that has one keeps it.",
        {"licence": "CC0-1.0", "licence_version": "2026-11-22"},
    ),
    "forgetSession": OperationText(
        "Capture",
        "Ends the session and deletes its views. What it has published already stays.",
    ),
    "showPose": OperationText(
        "Capture",
        "Answers with the pose in which the board should be held next, until a view answers it. "
        "`Accept` chooses between a picture to lay over the video (JPEG, PNG) and numbers. 409 "
        "once the session has converged.",
        accept="application/json",
    ),
    "submitView": OperationText(
        "Capture",
        "Submits the board's corners in one frame: their ids, and their positions in px, where "
        "the centre of the top-left pixel is (0, 0). At least six, not all on a line. `accepted` "
        "says whether the view became part of the session, and `reason` why not. The same view "
        "again is answered again.",
        {"index": 0, "ids": EXAMPLE_IDS, "points": EXAMPLE_POINTS},
    ),
    "submitViews": OperationText(
        "Capture",
        "Submits several views of a session that was started with `capture: recorded`. The service judges "
        "them in their order, as `POST /v1/session/views` would, and returns a result for each. If one "
        "has wrong fields, nothing is judged, and `errors` has one entry for each wrong view.",
        {"index": 0, "views": [{"ids": EXAMPLE_IDS, "points": EXAMPLE_POINTS}]},
    ),
    "undoView": OperationText(
        "Capture",
        "Takes a view out of the session. Its index is not used again.",
        path={"index": "0"},
    ),
    "finishSession": OperationText(
        "Capture",
        "Ends a recorded session with the views that agree, publishes the calibration, and "
        "answers with the state. At least four views must agree. Again is answered again.",
    ),
    "checkCalibration": OperationText(
        "Capture",
        "Scores the stored consensus of a camera on one to five fresh views, and counts the "
        "finding as a vote for or against it. Only the poses are fitted to the views. With "
        "`calibration` it compares that calibration with a fit of the views instead, and no vote "
        "counts. No session need be started under the session id.",
        {**_EXAMPLE_KEY, "views": [{"ids": EXAMPLE_IDS, "points": EXAMPLE_POINTS}]},
    ),
    "showCalibration": OperationText(
        "Database",
        "Answers with one stored calibration and the report of its session, or with one "
        "consensus. `format` asks for another tool's file; `crop`, `resize`, `rotate` and "
        "`mirror` convert it to a changed picture. `without` fits anew without some of the views; "
        "nothing is stored.",
        path={"id": "CALIBRATION_ID"},
    ),
    "convertFile": OperationText(
        "Database",
        "Reads the camera matrix and distortion of another program's file (OpenCV, ROS, Kalibr, COLMAP, "
        "mrcal, Gyroflow and others) and answers with the file in `format`. Nothing is stored. A file "
        "larger than 100,000 characters is refused; corners in it are kept in `photonvision` alone.",
        body={"file": EXAMPLE_FILE, "format": "kalibr"},
    ),
    "searchCameras": OperationText(
        "Database",
        "Finds cameras whose names hold, for each word of `query`, a word that begins with it. "
        "Without a query it lists all. Pass `next` as `after` for the following page.",
        query={"query": "c920"},
    ),
    "showCamera": OperationText(
        "Database",
        "Answers with everything that is known of one camera: by size and zoom, the calibrations, "
        "the groups in which they agree, and the consensus of each model.",
        path={"key": "CAMERA_KEY"},
    ),
    "lookupKnown": OperationText(
        "Lookup",
        "Looks a camera up by the digest of its label and platform. It needs no credential and no preflight, "
        "and caches keep the answer, so ask here first, then by POST after a 404.",
        path={
            "digest": alias_digest(EXAMPLE_CAMERA, EXAMPLE_PLATFORM),
            "size": "1280x720",
            "zoom": "0",
            "file": "rectilinear.json",
        },
    ),
    "showBadge": OperationText(
        "Database",
        "Answers with a picture for a README or a page: whether a camera is calibrated at a size, and to "
        "which error. It needs no credential.",
        path={"key": "CAMERA_KEY", "file": "1280x720.svg"},
    ),
    "createToken": OperationText(
        "Tokens",
        "Makes an API token for pages of some origins, and for programs. Nothing need be proved "
        "for origins of the machine itself, such as `http://localhost`. For an `https://` origin "
        "the answer says which proof to place. The token and its management token are shown this "
        "once. One source can make five a day.",
        {"origins": ["http://localhost", "https://page.example"], "name": "My page"},
    ),
    "showToken": OperationText(
        "Tokens",
        "Answers with the facts about a token, its limits, and its use by hour for two days and "
        "by day for thirty.",
    ),
    "changeToken": OperationText(
        "Tokens",
        "Gives a token other origins or another name. Origins that stay keep their state.",
        {"origins": ["http://localhost", "https://www.page.example"]},
    ),
    "revokeToken": OperationText(
        "Tokens",
        "Revokes a token for good, within a minute. Again is answered again.",
    ),
    "verifyToken": OperationText(
        "Tokens",
        "Looks for the proofs of all origins that are pending, at `https://<origin>/.well- "
        "known/calibdb.txt`. `failure` and `detail` of an origin say why there is none.",
    ),
    "rotateToken": OperationText(
        "Tokens",
        "Gives a token another secret, shown this once. The one until now opens for another day, "
        "or for `grace_s` seconds; 0 ends every earlier one at once.",
        {"grace_s": 3600},
    ),
    "showUsage": OperationText(
        "Tokens",
        "Answers with the limits of an API token's plan, and with its use in this hour by all and "
        "from your address. It counts as a lookup.",
    ),
    "createRig": OperationText(
        "Rigs",
        "Makes a rig of two to eight cameras. The session, which has no views yet, is camera 0 and leads. "
        "Other cameras join with `POST /v1/session` and `rig: {code, position?}`, from any device. The code "
        "is good for 15 minutes and until all cameras are there; the same request again answers the same "
        "rig and a fresh code. The board must not look the same after half a turn. With `square_size` "
        "lengths are in metres.",
        {"cameras": 2, "square_size": 0.03},
    ),
    "openMoment": OperationText(
        "Rigs",
        "Opens a moment: one pose of the board, held still, under an id that the leader makes. Each camera "
        "then sends its view of it with `POST /v1/session/views` and `moment`, at once or later. A rig has "
        "at most 100 moments.",
        {"moment": "m1"},
        path={"id": "RIG_ID"},
    ),
    "showRig": OperationText(
        "Rigs",
        "Answers with the state of a rig: who is there, which moments were answered and what of them is set "
        "aside, how large the error is expected to be, and where to hold the board next, as each camera "
        "sees it. Clients ask once a second with `If-None-Match`: 304 costs nothing of the plan.",
        path={"id": "RIG_ID"},
    ),
    "undoMoment": OperationText(
        "Rigs",
        "Undoes a moment. Its views are forgotten in all cameras, and late ones are refused.",
        path={"id": "RIG_ID", "moment": "m1"},
    ),
    "forgetRig": OperationText(
        "Rigs",
        "Forgets a running rig with the sessions of its cameras. A finished rig stays.",
        path={"id": "RIG_ID"},
    ),
    "finishRig": OperationText(
        "Rigs",
        "Ends a rig whose cameras are all linked and have four views that agree. Each camera's session is "
        "published as a calibration of its own; the rig keeps where they are.",
        path={"id": "RIG_ID"},
    ),
    "showRigResult": OperationText(
        "Rigs",
        "Answers with the cameras as they were fitted together and the pose of each, from camera 0. "
        "`format` chooses files of OpenCV (`opencv_stereo`), ROS, Kalibr, COLMAP, mrcal or glTF.",
        path={"id": "RIG_ID"},
    ),
    "health": OperationText("Service", "Answers 200 where the service is up. It needs no credential."),
}


def text_of(name: str) -> OperationText:
    """Return the words about a call; raises ValueError where somebody forgot them."""
    if name not in TEXTS:
        raise ValueError(f"infra/web_build/operation_texts.py has no words about {name}, nor its example")
    return TEXTS[name]
