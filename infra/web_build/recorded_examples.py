"""Responses of the service to the examples of `operations`: `python -m infra.web_build.recorded_examples`.

A server in memory gets five calibrations of one synthetic camera, then every example, in an order in which
each finds what it needs.
"""

import asyncio
import functools
import json
import sys
import time
from collections.abc import Iterator, Mapping
from typing import Any
from urllib.parse import urlencode

import httpx
import numpy as np

from calibsolver import Board, Camera
from calibsolver import rotation as rotations
from calibsolver.guidance import TargetPose, fixed_plan
from infra.server.jobs import JobWorker
from infra.server.server import DEVELOPMENT_TOKEN, Server
from infra.web_build.openapi import EXAMPLES_PATH
from infra.web_build.operations import OPERATIONS
from infra.web_build.site import ROOT

SCENARIO = (
    *("health", "createToken", "showToken", "changeToken", "verifyToken", "rotateToken", "showUsage"),
    *("lookup", "visitLookup", "searchCameras", "showCamera", "showCalibration", "showBadge", "convertFile"),
    "lookupKnown",
    *("openSession", "startSession", "showPose", "submitView", "showSession", "undoView", "checkCalibration"),
    *("licenseSession", "forgetSession", "submitViews", "finishSession"),
    *("createRig", "openMoment", "showRig", "undoMoment", "forgetRig", "finishRig", "showRigResult"),
    "revokeToken",
)
"""Names of all operations. `prepare_call` makes what some of them want."""
CALLS = {operation.name: operation for operation in OPERATIONS}
IMG_SIZE = (1280, 720)
CALIBRATIONS = 5
_VIEWS = 6
_CORNER_NOISE_PX = 0.1
_CONSENSUS_TIMEOUT_S = 60.0
_MAX_ITEMS, _KEPT_ITEMS = 8, 3  # of a list in the file
_DIGITS = 6
_TRUTH = Camera(
    "rectilinear",
    np.array([[958.0, 0.0, 641.2], [0.0, 957.1, 362.9], [0.0, 0.0, 1.0]]),
    np.array([0.062, -0.118, 0.0004, -0.0002, 0.021]),
    IMG_SIZE,
)


def _prepare(stack: Server) -> None:
    """Publish the calibrations by which the camera of the examples is reliable. Jobs run only here."""
    for session in [_record(stack, index) for index in range(CALIBRATIONS)]:  # one refit may do for several
        _send(stack, "POST", "/v1/session/finish", session)
    worker = JobWorker(stack.jobs)
    worker.start()
    end = time.monotonic() + _CONSENSUS_TIMEOUT_S
    while json.loads(_send(stack, "POST", "/v1/lookup", DEVELOPMENT_TOKEN, CALLS["lookup"].example)).get(
        "reason"
    ):
        if time.monotonic() > end:
            raise ValueError("the calibrations of the examples did not become a consensus")
        time.sleep(0.02)
    stack.wait_until_idle(_CONSENSUS_TIMEOUT_S)  # its label is an alias from here on
    worker.stop(_CONSENSUS_TIMEOUT_S)


def _record(stack: Server, seed: int) -> str:
    session = _start(stack, {"capture": "recorded"})
    views = [{"ids": ids, "points": points} for ids, points in _views(seed)]
    _send(stack, "POST", "/v1/session/batch", session, {"index": 0, "views": views})
    return session


def prepare_call(stack: Server, name: str, values: dict[str, str]) -> None:
    """Make the session or the rig that the example of a call requires."""
    match name:
        case "submitViews":
            values["SESSION_ID"] = _start(stack, {"capture": "recorded"})
        case "finishSession":
            values["SESSION_ID"] = _record(stack, CALIBRATIONS)
        case "createRig":
            values["SESSION_ID"] = _start(stack, {})
        case "finishRig":
            values["SESSION_ID"], values["RIG_ID"] = _capture_rig(stack)


def _start(stack: Server, options: dict[str, Any]) -> str:
    session: str = json.loads(_send(stack, "POST", "/v1/auth", DEVELOPMENT_TOKEN))["session_id"]
    _send(stack, "POST", "/v1/session", session, {**CALLS["startSession"].example, **options})
    return session


def _capture_rig(stack: Server) -> tuple[str, str]:
    leader = _start(stack, {})
    made = json.loads(_send(stack, "POST", "/v1/rigs", leader, CALLS["createRig"].example))
    rig = f"/v1/rigs/{made['rig_id']}"
    sessions = leader, _start(stack, {"rig": {"code": made["join_code"]}})
    for number, views in enumerate(zip(_views(1), _views(2, (-2.0, 0.0, 0.0)), strict=True)):
        _send(stack, "POST", f"{rig}/moments", leader, {"moment": f"m{number}"})
        for session, (ids, points) in zip(sessions, views, strict=True):
            view = {"ids": ids, "points": points, "moment": f"m{number}"}
            _send(stack, "POST", "/v1/session/views", session, view)
    return leader, made["rig_id"]


def _send(stack: Server, method: str, path: str, credential: str | None, body: Any = None) -> bytes:
    """Send a request that must succeed; return the body."""
    headers = {"authorization": f"Bearer {credential}"} if credential else {}
    headers |= {} if body is None else {"content-type": "application/json"}
    content = b"" if body is None else json.dumps(body).encode()
    answer = asyncio.run(
        _answer(stack, method, path, headers=headers | {"accept": "application/json"}, content=content)
    )
    if answer.status_code >= 400:
        raise ValueError(f"{method} {path}: {answer.status_code} {answer.text}")
    return answer.content


async def _answer(stack: Server, method: str, path: str, **options: Any) -> httpx.Response:
    transport = httpx.ASGITransport(stack.app, client=("127.0.0.1", 50_000))
    async with httpx.AsyncClient(
        transport=transport, base_url=stack.url, follow_redirects=True, timeout=60
    ) as page:
        return await page.request(method, path, **options)


def _views(
    seed: int, shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> Iterator[tuple[list[int], list[list[float]]]]:
    """Yield ids and pixels of the default board in the poses of the fixed plan, with noise.

    `shift`: translation from the first camera to the one that sees them, squares.
    """
    random = np.random.default_rng(seed)
    board = Board()
    for pose in _poses():
        pixels = _TRUTH.project(
            board.points @ rotations.matrix(np.asarray(pose.rvec)).T + np.asarray(pose.tvec) + shift
        )
        pixels = pixels + random.normal(scale=_CORNER_NOISE_PX, size=pixels.shape)
        inside = [
            i for i, (x, y) in enumerate(pixels) if 0 <= x < IMG_SIZE[0] - 1 and 0 <= y < IMG_SIZE[1] - 1
        ]
        yield inside, [[round(float(v), 2) for v in pixels[i]] for i in inside]


@functools.cache
def _poses() -> tuple[TargetPose, ...]:
    return fixed_plan(Board(), IMG_SIZE)[:_VIEWS]


def _examples() -> dict[str, Any]:
    answers: dict[str, Any] = {}
    values: dict[str, str] = {}
    with Server(environment={"NEW_TOKENS": "100"}, worker=1) as stack:
        _prepare(stack)
        for name in SCENARIO:
            prepare_call(stack, name, values)
            call = CALLS[name]
            query = f"?{urlencode(call.example_query)}" if call.example_query else ""
            path = fill_in(call.example_address + query, values)
            credential = fill_in(call.example_credential or "", values) or None
            body = _send(stack, call.method, path, credential, call.example)
            answers[name] = json.loads(body) if body.startswith((b"{", b"[")) else None
            learn(values, name, answers[name])
    return answers


def learn(values: dict[str, str], name: str, answer: Any) -> None:
    """Store values of a response for the placeholders of later examples."""
    match name:
        case "createToken":
            values["MANAGEMENT_TOKEN"] = answer["management_token"]
        case "openSession":
            values["SESSION_ID"] = answer["session_id"]
        case "lookup":
            values["CALIBRATION_ID"] = answer["id"]
        case "createRig":
            values["RIG_ID"] = answer["rig_id"]
        case "searchCameras":
            values["CAMERA_KEY"] = answer["cameras"][0]["key"]


def fill_in(text: str, values: Mapping[str, str]) -> str:
    """Put values in the place of their placeholders."""
    for placeholder, value in values.items():
        text = text.replace(placeholder, value)
    return text


def text() -> str:
    """Return the file's content. Its tokens were those of a server in memory, which is gone."""
    return json.dumps(_shorten(_examples()), indent=1, ensure_ascii=False) + "\n"


def _shorten(node: Any) -> Any:
    """Cut long lists, and round numbers, for readers."""
    if isinstance(node, dict):
        return {key: _shorten(value) for key, value in node.items()}
    if isinstance(node, list):
        return [_shorten(value) for value in (node if len(node) <= _MAX_ITEMS else node[:_KEPT_ITEMS])]
    return round(node, _DIGITS) if isinstance(node, float) else node


if __name__ == "__main__":
    EXAMPLES_PATH.parent.mkdir(exist_ok=True)
    EXAMPLES_PATH.write_text(text(), encoding="utf-8")
    print(f"{EXAMPLES_PATH.relative_to(ROOT)}: {EXAMPLES_PATH.stat().st_size} bytes", file=sys.stderr)
