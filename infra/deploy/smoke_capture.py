"""One whole capture on a deployment, and its removal."""

import functools
import json
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import Any

import httpx
import numpy as np

from calibdb.schema import RefitRequest
from calibdb.store import Calibrations, aws
from calibdb.store.keys import calibration_object, tombstone_object
from calibdb.store.storage import storage_named
from calibsolver import Board, Camera
from calibsolver import rotation as rotations
from infra.deploy import smoke
from infra.ops.replica import ReplicatedObjects

CAMERA = "calibDB smoke test"
_SEED = 1
_MAX_BUSY_ATTEMPTS = 10  # where the deployment says that it has no time
_TARGET_ERROR_PX = 100.0  # px: the fourth accepted view ends the capture
_NOISE_PX = 0.15  # px
_IMG_SIZE = (1280, 720)
# (rvec about x and y, rad) of a board that teaches something each time
_TILTS = ((0.5, 0.0), (-0.5, 0.1), (0.1, 0.55), (0.0, -0.6), (0.4, 0.4), (-0.4, -0.4), (0.45, -0.4))

View = tuple[int, list[int], list[list[float]]]  # index, ids, points
Call = Callable[..., Any]
"""Method, path, credential and body to the JSON of a response."""


class CallError(RuntimeError):
    """A deployment did not do what it must."""


@dataclass
class CaptureRecord:
    """The views and the calibration of one capture that the server acknowledged."""

    views: list[View] = field(default_factory=list)
    calibration_id: str | None = None


def call(ask: smoke.Ask, method: str, path: str, credential: str, body: object = None) -> Any:
    """Send a request, again while the deployment has no time. Raises CallError if it is refused."""
    content = None if body is None else json.dumps(body).encode()
    for attempt in range(_MAX_BUSY_ATTEMPTS):
        if attempt:
            time.sleep(1)
        response = ask(method, path, {"Authorization": f"Bearer {credential}"}, content)
        if response.status_code != HTTPStatus.SERVICE_UNAVAILABLE:
            break
    if not response.is_success:
        raise CallError(f"{method} {path}: {response.status_code} {response.content[:300]!r}")
    return response.json()


def capture(call: Call, token: str, seed: int, camera: str, *, finish: bool = True) -> CaptureRecord:
    """Run one capture and return what was acknowledged; without `finish`, end after a view.

    Raises CallError if it does not converge, or has other views than were acknowledged.
    """
    record = CaptureRecord()
    session = call("POST", "/v1/auth", token)["session_id"]
    start = {
        "camera": camera,
        "platform": "X11; Linux x86_64",
        "img_size": _IMG_SIZE,
        "target_error": _TARGET_ERROR_PX,
    }
    state = call("POST", "/v1/session", session, start)
    for ids, points in observe_board(seed):
        if state["status"] == "converged" or (record.views and not finish):
            break
        index = len(record.views)
        view = {"index": index, "ids": ids, "points": points}
        state = call("POST", "/v1/session/views", session, view)
        if state["accepted"]:
            record.views.append((index, ids, points))
    record.calibration_id = state["calibration_id"]
    if finish and record.calibration_id is None:
        raise CallError(f"a capture of {camera} did not converge: {state['views']}")
    state = call("GET", "/v1/session", session)
    if [(v["index"], v["points"]) for v in state["views"]] != [(n, len(ids)) for n, ids, _ in record.views]:
        raise CallError(f"a capture of {camera} has other views than were acknowledged: {state['views']}")
    return record


def observe_board(seed: int) -> Iterator[tuple[list[int], list[list[float]]]]:
    """Yield ids and points that a detector would find on one capture's frames."""
    rng = np.random.default_rng(seed)
    board = Board()
    matrix = np.array([[950.0, 0.0, 652.0], [0.0, 948.0, 351.0], [0.0, 0.0, 1.0]])
    camera = Camera("rectilinear", matrix, np.array([-0.12, 0.05, 0.0005, -0.0004, 0.0]), _IMG_SIZE)
    for n, (x, y) in enumerate(_TILTS):
        rotation = rotations.matrix(np.array([x, y, 0.1 * n]) + rng.normal(0, 0.04, 3))
        place = np.array([-4.5 + (n % 3 - 1), -3.0 + 0.5 * (n % 2), 9.0 + n % 4])
        q = camera.project(board.points @ rotation.T + place) + rng.normal(
            0, _NOISE_PX, (len(board.points), 2)
        )
        inside = np.flatnonzero(((q >= 0) & (q <= np.array(_IMG_SIZE) - 1)).all(axis=1))
        yield inside.tolist(), q[inside].tolist()


def problems(site: smoke.Site, token: str, remove: Callable[[str], None]) -> Iterator[str]:
    """Find why a capture with the pages' token fails; `remove` receives the id of its calibration."""
    ask = functools.partial(call, smoke.make_requester(site.url, site.distribution))
    try:
        identity = str(capture(ask, token, _SEED, CAMERA).calibration_id)
    except (CallError, OSError, httpx.HTTPError) as error:
        yield f"a capture: {error}"
        return
    try:
        response = ask("GET", f"/v1/calibrations/{identity}", token)
        if response.get("id") != identity:
            yield f"GET /v1/calibrations/{identity}: {response.get('id')}"
    except (CallError, OSError, httpx.HTTPError) as error:
        yield str(error)
    finally:
        remove(identity)


def remove(made: Mapping[str, str], region: str, refit: str, identity: str) -> None:
    """Remove a calibration, and have its consensus computed again by the function `refit`.

    `made`: outputs of the stack. Versions expire with the bucket's rule: a deployment may not remove
    versions.
    """
    table = storage_named(region, made["TableName"]).table
    # A replica must not keep it either.
    objects = ReplicatedObjects(made["KeypointBucketName"], region)
    calibrations = Calibrations(table, objects)
    document = calibrations.get(identity)
    if document is None:
        return
    calibrations.withdraw(document, "other: smoke test", int(time.time()))
    names = (calibration_object(identity), tombstone_object(identity))
    calibrations.unindex(document)
    for place in filter(None, (objects.replica, objects)):
        place.delete([name for name in names if name])
    request = RefitRequest(camera=document.camera_key, img_size=document.img_size, zoom=document.zoom)
    aws.lambda_(region).invoke(
        FunctionName=refit, InvocationType="Event", Payload=request.model_dump_json().encode()
    )
