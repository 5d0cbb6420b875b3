"""A client of the API as a test sees it, and a camera with a known truth for it to calibrate."""

import json
import re
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np

from infra.server.server import Server
from infra.web_build.openapi import OPERATIONS
from infra.web_build.operation import Operation
from tests.helpers.service.in_process import Response as Answer
from tests.helpers.service.in_process import request

TOKEN = "cdb_dev_local"
CAMERA = {"camera": "Test camera", "platform": "X11; Linux x86_64", "img_size": [1280, 720]}


def until(holds: Callable[[], Any], seconds: float = 120.0) -> Any:
    end = time.monotonic() + seconds
    while not (found := holds()):
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.02)
    return found


def described(method: str, path: str) -> Operation | None:
    for operation in OPERATIONS:
        pattern = re.sub(r"\\{[^}]*\\}", "[^/]+", re.escape(operation.path))
        if operation.method.upper() == method and re.fullmatch(pattern, path):
            return operation
    return None


EDGE = "only the edge knows this"
#: a start of a capture that ends at its fourth view, for what needs a calibration and not a good one
BRIEF: Mapping[str, Any] = {"target_error": 100.0}


@dataclass
class Client:
    """Speaks HTTP to a server, or to an emulated stack, with the credential that the call wants."""

    stack: Any
    session_id: str = ""
    api_token: str = TOKEN
    address: str = ""  # where they are, to a server of this process

    def call(
        self,
        method: str,
        path: str,
        body: object = None,
        *,
        token: str | None = None,
        query: str = "",
        headers: Mapping[str, str] | None = None,
    ) -> Answer:
        """`body`: bytes are sent as they are, everything else as JSON; `token`: None sends what is wanted."""
        operation = described(method, path)
        if token is None:
            wants_session = operation is None or "sessionId" in operation.credentials
            token = self.session_id if wants_session else self.api_token if operation.credentials else ""
        sent = dict(headers or {})
        if token:
            sent["authorization"] = f"Bearer {token}"
        content = body if isinstance(body, bytes) else b"" if body is None else json.dumps(body).encode()
        if content:
            sent.setdefault("content-type", "application/json")
        if isinstance(self.stack, Server):
            caller = self.address or "127.0.0.1"
            answer = request(self.stack, method, path, sent, query, content, client=caller)
        else:
            answer = self.stack.request(method, path, headers=sent, query=query, body=content)
        promised = {*operation.answers, *operation.all_problems} if operation else {404, 405}
        assert answer.status in promised, (method, path, answer)
        if answer.status >= 400:
            assert answer.headers["content-type"] == "application/problem+json", answer
            assert {"type", "title", "status", "detail"} <= answer.json.keys(), answer
            assert answer.json["status"] == answer.status
        return answer

    def authenticate(self, token: str | None = None) -> None:
        opened = self.call("POST", "/v1/auth", token=token)
        assert opened.status == 201, opened.body
        self.session_id = opened.json["session_id"]

    def open(self, **start: object) -> Answer:
        self.authenticate()
        return self.call("POST", "/v1/session", {**CAMERA, **start})

    def pose(self, query: str = "") -> Answer:
        return self.call("GET", "/v1/session/pose", headers={"accept": "application/json"}, query=query)

    def view(self, index: float, ids: object, points: object) -> Answer:
        return self.call("POST", "/v1/session/views", {"index": index, "ids": ids, "points": points})

    def state(self) -> Any:
        return self.call("GET", "/v1/session").json

    def finish(self) -> Answer:
        return self.call("POST", "/v1/session/finish")

    def forget(self) -> Answer:
        return self.call("DELETE", "/v1/session")

    def calibration(self, name: object, query: str = "") -> Answer:
        return self.call("GET", f"/v1/calibrations/{name}", query=query)

    def check(self, views: object, **asked: object) -> Answer:
        self.authenticate()
        return self.call("POST", "/v1/checks", {**CAMERA, "views": views, **asked})

    def lookup(self, **asked: object) -> Answer:
        return self.call("POST", "/v1/lookup", {**CAMERA, **asked})


@dataclass
class Truth:
    """A camera whose parameters are known, in the hands of someone who misses each pose a little."""

    fx: float = 950.0
    fy: float = 948.0
    cx: float = 652.0
    cy: float = 351.0
    distortion: tuple[float, ...] = (-0.12, 0.05, 0.0005, -0.0004, 0.0)
    img_size: tuple[int, int] = (1280, 720)
    squares: tuple[int, int] = (9, 6)
    noise: float = 0.15  # px
    sag: float = 0.0  # squares, height of the board's middle over its ends
    seed: int = 0
    rng: np.random.Generator = field(init=False)

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)

    @property
    def matrix(self) -> np.ndarray:
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1]])

    def see(self, pose: Mapping[str, Any]) -> tuple[list[int], list[list[float]]]:
        """Return ids and points that a detector would find with the board held at `pose`, about."""
        rvec = np.array(pose["rvec"]) + self.rng.normal(0, 0.04, 3)
        tvec = np.array(pose["tvec"]) * (1 + self.rng.normal(0, 0.02, 3))
        return self.detect(rvec, tvec)

    @property
    def board(self) -> np.ndarray:
        """Corners (n, 3) of the board, squares."""
        columns, rows = self.squares[0] - 1, self.squares[1] - 1
        row, column = np.divmod(np.arange(columns * rows), columns)
        height = self.sag * (1 - np.linspace(-1, 1, columns)[column] ** 2)
        return np.stack([column + 1.0, row + 1.0, height], axis=1)

    def detect(self, rvec: np.ndarray, tvec: np.ndarray) -> tuple[list[int], list[list[float]]]:
        """Return ids and points that a detector would find with the board exactly at a pose."""
        lens = np.array(self.distortion)
        points = cv2.projectPoints(self.board, rvec, tvec, self.matrix, lens)[0].reshape(-1, 2)
        points = points + self.rng.normal(0, self.noise, points.shape)
        limit = np.array(self.img_size) - 1
        seen = np.flatnonzero(((points >= 0) & (points <= limit)).all(axis=1))
        return seen.tolist(), points[seen].tolist()

    def show(self, client: Client) -> Answer:
        pose = client.pose()
        assert pose.status == 200, pose.body
        answer = client.view(pose.json["index"], *self.see(pose.json))
        assert answer.status == 200, answer.body
        return answer

    def calibrate(self, client: Client, max_views: int = 12, **start: object) -> Any:
        """Run a whole guided capture, and return the state it ends in."""
        opened = client.open(**{"img_size": list(self.img_size)} | start)
        assert opened.status == 201, opened.body
        return self.finish(client, max_views)

    def finish(self, client: Client, max_views: int = 12) -> Any:
        for _ in range(max_views):
            answer = self.show(client)
            if answer.json["status"] == "converged":
                return answer.json
        raise AssertionError(f"not converged after {max_views} views: {answer.body!r}")
