"""A camera with a known truth, and a person in front of it who does what the text says."""

from dataclasses import dataclass, field
from typing import ClassVar

import cv2
import numpy as np

from calibdb_client import Board
from calibdb_client.board_sheet import png
from calibdb_client.capture.feedback import Scene
from calibdb_client.capture.guide import Status
from calibdb_client.capture.outline import TEXTS

SQUARE_PX = 60
BORDER_PX = 60
SHOW = "show the board to the camera"
STEP, TURN = 0.08, 0.12  # of the distance; rad
MOVES = {
    "left": (-1, 0, 0),
    "right": (1, 0, 0),
    "up": (0, -1, 0),
    "down": (0, 1, 0),
    "closer": (0, 0, -1),
    "farther": (0, 0, 1),
}
TURNS = {
    "tilt_top": (1, 0, 0),
    "tilt_bottom": (-1, 0, 0),
    "tilt_left": (0, -1, 0),
    "tilt_right": (0, 1, 0),
    "turn_clockwise": (0, 0, 1),
    "turn_counterclockwise": (0, 0, -1),
}


@dataclass
class BoardCamera:
    """Camera with a known truth that has drawn frames of a board; `clock` is their time."""

    frame_s: ClassVar[float]
    board: Board = field(default_factory=Board)
    size: tuple[int, int] = (640, 480)
    fx: float = 570.0
    seed: int = 0
    frames: int = 0

    def __post_init__(self) -> None:
        self.rng = np.random.default_rng(self.seed)
        w, h = self.size
        self.matrix = np.array([[self.fx, 0, w / 2 + 4], [0, self.fx, h / 2 - 3], [0, 0, 1.0]])
        self.distortion = np.array([-0.08, 0.01, 0, 0, 0])
        drawn = np.frombuffer(png(self.board, SQUARE_PX), np.uint8)
        self.sheet = cv2.imdecode(drawn, cv2.IMREAD_GRAYSCALE)
        self.middle = np.array([*self.board.edge.mean(axis=0), 0])

    def clock(self) -> float:
        return self.frames * self.frame_s


@dataclass
class VirtualCamera(BoardCamera):
    """Source of pictures (h, w), with distortion and noise, of a board in a hand that follows words."""

    frame_s = 0.12
    words: str = ""

    def __post_init__(self) -> None:
        super().__post_init__()
        w, h = self.size
        # A pinhole camera sees some more than the lens; its picture is then bent.
        self.pinhole = np.add(self.matrix, [[0, 0, BORDER_PX], [0, 0, BORDER_PX], [0, 0, 0]])
        pixels = np.indices((h, w), dtype=np.float64)[::-1].reshape(2, -1).T
        bent = cv2.undistortPoints(pixels[:, None], self.matrix, self.distortion, P=self.pinhole)
        self.lens = cv2.convertMaps(bent.reshape(h, w, 2).astype(np.float32), None, cv2.CV_16SC2)
        self.grain = [np.clip(self.rng.normal(0, 1, (h, w)), -20, 20).astype(np.int8) for _ in range(7)]
        self.rotation, self.place = np.eye(3), np.array([0, 0, 1.4 * max(self.board.size)])

    def read(self) -> tuple[bool, np.ndarray]:
        self.frames += 1
        self.follow(self.words)
        return True, self.picture()

    def picture(self) -> np.ndarray:
        origin = self.place - self.rotation @ self.middle
        left, top = self.board.edge[0] + 0.5 / SQUARE_PX - 0.5
        to_board = np.array([[1 / SQUARE_PX, 0, left], [0, 1 / SQUARE_PX, top], [0, 0, 1]])
        onto = self.pinhole @ np.column_stack([self.rotation[:, :2], origin]) @ to_board
        size = (self.size[0] + 2 * BORDER_PX, self.size[1] + 2 * BORDER_PX)
        flat = cv2.GaussianBlur(cv2.warpPerspective(self.sheet, onto, size, borderValue=150), (0, 0), 0.7)
        seen = cv2.remap(flat, *self.lens, cv2.INTER_LINEAR)
        return cv2.add(seen, self.grain[self.frames % len(self.grain)], dtype=cv2.CV_8U)

    def follow(self, words: str) -> None:
        codes = {text: code for code, text in TEXTS.items()} | {SHOW: "farther"}
        code = codes.get(words, "")
        self.place = self.place + STEP * self.place[2] * np.array(MOVES.get(code, (0, 0, 0)))
        self.place[2] = np.clip(self.place[2], 3, 60)
        turn = TURN * np.array(TURNS.get(code, (0, 0, 0)), dtype=np.float64)
        self.rotation = cv2.Rodrigues(turn)[0] @ self.rotation


@dataclass
class Listener:
    camera: VirtualCamera
    said: list[str] = field(default_factory=list)
    views: int = 0
    closed: bool = False

    def show(self, scene: Scene) -> str:
        self.camera.words = scene.instruction
        return ""

    def taken(self, status: Status) -> None:
        self.views = status.views

    def note(self, text: str) -> None:
        self.said.append(text)

    def close(self) -> None:
        self.closed = True
