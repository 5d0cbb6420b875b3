"""A camera and a hand like real ones: 15 frames/s of a board of bent paper that is never quite still.

Pictures have noise, rolling shutter, motion blur and JPEG. The person follows the drawn outline after a
reaction time, misses it, and tries again if no view is taken.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from calibdb_client.capture.feedback import Scene
from calibdb_client.capture.guide import Status, Target
from tests.helpers.virtual_person import SQUARE_PX, BoardCamera

SQUARE_MM = 30.0
READOUT_S, EXPOSURE_S = 0.02, 0.015
BACKGROUND = 150
COARSE_PX = 8
"""Spacing of the pixels whose rays are traced; those between are interpolated."""
MAX_SHARP_PX = 0.5
"""Motion during the exposure that blurs nothing."""
PATIENCE_S = 2.5
"""Time held at a place before it is tried again."""
OFF_DEGREES, OFF_SHARE = 5.0, 0.05
"""Standard deviation by which a pose is missed: per axis, and of the distance."""
TREMOR = np.repeat([np.radians(0.1), 0.3 / SQUARE_MM], 3)
"""Amplitude at 7 to 11 Hz, of rotations (rad) and places (squares)."""
DRIFT = np.repeat([np.radians(0.3), 2.0 / SQUARE_MM], 3)
"""Velocity per second, root mean square."""
NOISE, JPEG_QUALITY = 2.0, 85


@dataclass(frozen=True, eq=False)
class Pose:
    """Rotation (3, 3) of the board, and place (3,) of its middle before the camera, squares."""

    rotation: np.ndarray
    place: np.ndarray

    def moved(self, turn: np.ndarray, shift: np.ndarray) -> "Pose":
        """Pose after a turn (3,) rad and a shift (3,)."""
        return Pose(cv2.Rodrigues(turn)[0] @ self.rotation, self.place + shift)

    def towards(self, other: "Pose", share: float) -> "Pose":
        turn = cv2.Rodrigues(other.rotation @ self.rotation.T)[0].ravel()
        return self.moved(share * turn, share * (other.place - self.place))


@dataclass
class RealCamera(BoardCamera):
    """Source of pictures (h, w) of a board in a hand, and `Feedback`.

    `bend_mm`: height of the board's middle over its edges. `follows`: False holds the board anywhere.
    """

    frame_s = 1 / 15
    bend_mm: float = 1.0
    follows: bool = True

    def __post_init__(self) -> None:
        super().__post_init__()
        self.phases, self.rates = self.rng.uniform(0, 2 * np.pi, 6), self.rng.uniform(7, 11, 6)
        self.bend_axis = self.rng.uniform(0, np.pi)
        self.drift = np.zeros(6)
        w, h = self.size
        self.grain = [self.rng.normal(0, NOISE, (h, w)).astype(np.float32) for _ in range(7)]
        start = Pose(np.eye(3), np.array([0, 0, 1.4 * max(self.board.size)]))
        self.begin, self.goal, self.leaves_at, self.arrives_at = start, start, 0.0, 0.0
        self.target: Target | None = None

    def read(self) -> tuple[bool, np.ndarray]:
        self.frames += 1
        velocity = DRIFT * self.rng.normal(size=6)
        self.drift = 0.98 * self.drift + velocity * self.frame_s
        if not self.follows and self.clock() > self.arrives_at + PATIENCE_S:
            self.leave(self.anywhere())
        return True, self.picture()

    def show(self, scene: Scene) -> str:
        if not self.follows:
            return ""
        is_new = self.target is not scene.target
        if is_new or self.clock() > self.arrives_at + PATIENCE_S:
            self.target = scene.target
            self.leave(self.missed(self.matched(scene.target)), self.rng.uniform(0.5, 1.0) if is_new else 0.2)
        return ""

    def leave(self, goal: Pose, after: float = 0.0) -> None:
        self.begin, self.goal = self.held(self.clock()), goal
        self.leaves_at = self.clock() + after
        way_mm = SQUARE_MM * float(np.linalg.norm(goal.place - self.begin.place))
        self.arrives_at = self.leaves_at + float(np.clip(way_mm / 250, 0.6, 1.8))

    def matched(self, target: Target) -> Pose:
        """Pose in which the board looks like the drawing."""
        columns = self.board.squares[0] - 1
        row, column = np.divmod(np.array(target.ids), columns)
        points = np.stack([column + 1.0, row + 1.0, np.zeros(len(row))], axis=1)
        _, rvec, tvec = cv2.solvePnP(points, target.corners, self.matrix, self.distortion)
        rotation = cv2.Rodrigues(rvec)[0]
        return Pose(rotation, rotation @ self.middle + tvec.ravel())

    def missed(self, pose: Pose) -> Pose:
        turn = np.radians(OFF_DEGREES) * self.rng.normal(size=3)
        shift = OFF_SHARE * np.linalg.norm(pose.place) * self.rng.normal(size=3)
        return pose.moved(turn, shift)

    def anywhere(self) -> Pose:
        depth = self.rng.uniform(1.1, 1.8) * max(self.board.size)
        place = np.array([self.rng.uniform(-0.3, 0.3) * depth, self.rng.uniform(-0.2, 0.2) * depth, depth])
        return Pose(cv2.Rodrigues(np.radians(25) * self.rng.normal(size=3))[0], place)

    def held(self, time: float) -> Pose:
        """Pose by a movement of least jerk."""
        s = np.clip((time - self.leaves_at) / max(self.arrives_at - self.leaves_at, 1e-9), 0, 1)
        pose = self.begin.towards(self.goal, s**3 * (10 - 15 * s + 6 * s * s))
        move = self.drift + TREMOR * np.sin(2 * np.pi * self.rates * time + self.phases)
        return pose.moved(move[:3], move[3:])

    def taken(self, status: Status) -> None:
        pass

    def note(self, text: str) -> None:
        pass

    def close(self) -> None:
        pass

    @cached_property
    def rays(self) -> np.ndarray:
        """Rays (h, w, 3) of every COARSE_PX-th pixel, and of one more beyond the edge."""
        w, h = self.size
        x, y = np.meshgrid(np.arange(0, w + COARSE_PX, COARSE_PX), np.arange(0, h + COARSE_PX, COARSE_PX))
        pixels = np.stack([x, y], axis=-1).astype(np.float64)
        flat = cv2.undistortPoints(pixels.reshape(-1, 1, 2), self.matrix, self.distortion)
        return np.concatenate([flat.reshape(*x.shape, 2), np.ones((*x.shape, 1))], axis=-1)

    def picture(self) -> np.ndarray:
        time = self.clock()
        shift = self.held(time + EXPOSURE_S / 2).place - self.held(time - EXPOSURE_S / 2).place
        is_sharp = self.fx * np.linalg.norm(shift) / self.held(time).place[2] < MAX_SHARP_PX
        parts = (0.0,) if is_sharp else (-0.33, 0.0, 0.33)
        seen = sum(self.exposed(time + part * EXPOSURE_S) / len(parts) for part in parts)
        grey = cv2.add(seen, self.grain[self.frames % len(self.grain)], dtype=cv2.CV_8U)
        _, jpeg = cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
        return cv2.imdecode(jpeg, cv2.IMREAD_GRAYSCALE)

    def exposed(self, time: float) -> np.ndarray:
        """Picture (h, w) of an instant, each row at its own time."""
        rays = self.rays
        first, last = (self.held(time + each * READOUT_S) for each in (-0.5, 0.5))
        share = np.linspace(0, 1, len(rays))[:, None]
        rotations = first.rotation + share[..., None] * (last.rotation - first.rotation)
        origins = first.place + share * (last.place - first.place) - rotations @ self.middle
        d = np.einsum("hij,hwi->hwj", rotations, rays)  # into the frame of the board
        o = np.einsum("hij,hi->hj", rotations, -origins)[:, None]
        height = 0.0
        for _ in range(3):
            s = (height - o[..., 2]) / d[..., 2]
            point = o[..., :2] + s[..., None] * d[..., :2]
            height = self.bend(point)
        left, top = self.board.edge[0]
        at = (np.where(s > 0, point[..., 0], -1e3) - left + 0.5, point[..., 1] - top + 0.5)
        w, h = self.size
        maps = [enlarged((each * SQUARE_PX - 0.5).astype(np.float32), (w, h)) for each in at]
        seen = cv2.remap(
            self.sheet, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=BACKGROUND
        )
        return cv2.GaussianBlur(seen, (0, 0), 0.7).astype(np.float32)

    def bend(self, point: np.ndarray) -> np.ndarray:
        """Height of the paper over its plane at points (..., 2), squares: a part of a cylinder."""
        half = max(self.board.size) / 2
        axis = np.array([np.cos(self.bend_axis), np.sin(self.bend_axis)])
        across = np.clip((point - self.middle[:2]) @ axis / half, -1, 1)
        return self.bend_mm / SQUARE_MM * (1 - across**2)


def enlarged(coarse: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    w, h = size
    down = np.array([[1 / COARSE_PX, 0, 0], [0, 1 / COARSE_PX, 0]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(coarse, down, (w, h), flags=flags, borderMode=cv2.BORDER_REPLICATE)
