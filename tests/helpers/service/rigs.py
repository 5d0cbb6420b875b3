"""A rig of simulated cameras whose places are known, in front of which somebody holds a board."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from calibsolver import rotation
from calibsolver.rig.start import RigidMotion
from infra.server.server import Server
from tests.helpers.service.client import CAMERA, TOKEN, Answer, Client, Truth

MIN_SEEN = 12
"""Corners of a view, at least."""


@dataclass
class RigTruth:
    """Cameras side by side, `baseline` squares apart, each with a client of its own; camera 0 leads."""

    stack: Server
    count: int = 2
    squares: tuple[int, int] = (9, 6)
    dictionary: str = "DICT_APRILTAG_36h10"
    baseline: float = 2.0
    noise: float = 0.15  # px
    seed: int = 0
    address: str = ""
    api_token: str = TOKEN
    start: Mapping[str, object] = field(default_factory=dict)
    rig_id: str = ""
    join_code: str = ""

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)
        self.clients = [Client(self.stack, "", self.api_token, self.address) for _ in range(self.count)]
        self.cameras = [
            Truth(
                fx=950 + 10 * i, fy=948 + 10 * i, squares=self.squares, noise=self.noise, seed=self.seed + i
            )
            for i in range(self.count)
        ]
        self.motions = [
            RigidMotion(
                rotation.matrix(np.array([0.01, 0.02, 0.005]) * i),
                np.array([-self.baseline, 0.05, 0.02]) * i,
            )
            for i in range(self.count)
        ]
        self.sent = [0] * self.count

    def request(self, position: int) -> dict[str, object]:
        board = {"squares": list(self.squares), "dictionary": self.dictionary}
        return {**CAMERA, "camera": f"Rig camera {position}", "board": board, **self.start}

    def lead(self, **more: object) -> "RigTruth":
        """Begin the rig by its first camera."""
        leader = self.clients[0]
        assert leader.open(**self.request(0)).status == 201
        made = leader.call("POST", "/v1/rigs", {"cameras": self.count, **more})
        assert made.status == 201, made.body
        self.rig_id, self.join_code = made.json["rig_id"], made.json["join_code"]
        return self

    def open(self, **more: object) -> "RigTruth":
        self.lead(**more)
        for position in range(1, self.count):
            joined = self.join(position)
            assert joined.status == 201, joined.body
        return self

    def join(self, position: int, /, **rig: object) -> Answer:
        wanted = rig or {"code": self.join_code, "position": position}
        return self.clients[position].open(**self.request(position), rig=wanted)

    def call(
        self, method: str, path: str = "", body: object = None, position: int = 0, **more: Any
    ) -> Answer:
        return self.clients[position].call(method, f"/v1/rigs/{self.rig_id}{path}", body, **more)

    def state(self, position: int = 0) -> Any:
        answer = self.call("GET", position=position)
        assert answer.status == 200, answer.body
        return answer.json

    def held(self, state: Any = None) -> RigidMotion:
        """Pose, board -> camera 0, near the target of a state, or one that cameras in the middle see."""
        target = state and state["target"]
        if target:
            view = target["cameras"][0]
            pose = RigidMotion.of_vector(np.array([*view["rvec"], *view["tvec"]], dtype=np.float64))
            missed = rotation.matrix(self.rng.normal(0, 0.03, 3))
            pose = RigidMotion(missed @ pose.r, pose.t * (1 + self.rng.normal(0, 0.02)))
            return self.motions[view["position"]].inverse() @ pose
        r = rotation.matrix(self.rng.uniform(-0.5, 0.5, 3) * (1, 1, 0.4))
        depth = max(self.squares) * self.rng.uniform(1.1, 1.8)
        across = self.baseline * (self.count - 1) / 2
        place = np.array([across, 0, 0]) + depth * np.array([*self.rng.uniform(-0.2, 0.2, 2), 1])
        return RigidMotion(r, place - r @ [self.squares[0] / 2, self.squares[1] / 2, 0])

    def see(self, position: int, pose: RigidMotion) -> tuple[list[int], list[list[float]]]:
        truth, pose = self.cameras[position], self.motions[position] @ pose
        is_behind = pose(truth.board)[:, 2] <= 0.5
        seen = zip(*truth.detect(rotation.vector(pose.r), pose.t), strict=True)
        found = [(number, point) for number, point in seen if not is_behind[number]]
        return [number for number, _ in found], [point for _, point in found]

    def moment(
        self, name: str, pose: RigidMotion | None = None, positions: Sequence[int] | None = None
    ) -> dict[int, Answer]:
        """Open a moment; answers, by position, to the views of the cameras that see enough of the board."""
        opened = self.call("POST", "/moments", {"moment": name})
        assert opened.status == 201, opened.body
        pose = self.held() if pose is None else pose
        found = {}
        for position in range(self.count) if positions is None else positions:
            ids, points = self.see(position, pose)
            if len(ids) >= MIN_SEEN:
                found[position] = self.view(position, name, ids, points)
        return found

    def view(self, position: int, moment: str, ids: object, points: object) -> Answer:
        """Send a view of a moment."""
        body = {"index": self.sent[position], "ids": ids, "points": points, "moment": moment}
        answer = self.clients[position].call("POST", "/v1/session/views", body)
        self.sent[position] += answer.status == 200
        return answer

    def result(self, name: str = "json") -> Answer:
        return self.call("GET", "/result", query=f"format={name}", token=self.api_token)
