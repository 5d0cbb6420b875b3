"""What to do, in a few words: from where the board is to where it should be."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from .. import rotation
from ..arrays import Array
from ..board import Board
from ..camera import Camera

Code = Literal[
    "first",
    "closer",
    "farther",
    "left",
    "right",
    "up",
    "down",
    "tilt_top",
    "tilt_bottom",
    "tilt_left",
    "tilt_right",
    "turn_clockwise",
    "turn_counterclockwise",
    "show_more",
    "hold_still",
    "unmirror",
]

TEXTS: dict[Code, str] = {
    "first": "Match the outline with the board",
    "closer": "Bring the board closer",
    "farther": "Move the board farther away",
    "left": "Move the board left",
    "right": "Move the board right",
    "up": "Move the board up",
    "down": "Move the board down",
    "tilt_top": "Tilt top edge towards the camera",
    "tilt_bottom": "Tilt bottom edge towards the camera",
    "tilt_left": "Tilt left edge towards the camera",
    "tilt_right": "Tilt right edge towards the camera",
    "turn_clockwise": "Turn the board clockwise",
    "turn_counterclockwise": "Turn the board counterclockwise",
    "show_more": "Show more of the board",
    "hold_still": "Hold the board still, and again",
    "unmirror": "Turn off the camera's mirroring",
}
"""At most six words each. Directions are those of the camera's picture: a page that mirrors its preview swaps
left and right, and the sense of a turn."""

MOVE, NEAR, TILT, TURN = 0.12, 0.15, 12.0, 20.0
"""Equally conspicuous: a shift / image width, a logarithm of distances, a tilt and a turn, degrees."""


@dataclass(frozen=True)
class Hint:
    """One instruction: a code for programs, an English text of at most six words for people."""

    code: Code
    text: str

    @classmethod
    def of(cls, code: Code) -> "Hint":
        """Return the hint with this code."""
        return cls(code, TEXTS[code])


@dataclass(frozen=True, eq=False)
class Placement:
    """A board in the picture, as a person sees it.

    Attributes
    ----------
    place
        (2,) px, its centre.
    distance
        Squares, of its centre from the camera.
    normal
        (3,) away from the viewer, in a frame whose z axis is the line of sight to the centre.
    turn
        Radians, clockwise in the picture.
    """

    place: Array
    distance: float
    normal: Array
    turn: float

    @classmethod
    def of(cls, board: Board, camera: Camera, r: Array, t: Array) -> "Placement":
        """Placement of a board at rotation (3, 3) and translation (3,)."""
        center = r @ board.outline.mean(axis=0) + t
        distance = float(np.linalg.norm(center))
        upright = rotation.matrix(turn_to(center / distance)).T @ r
        return cls(
            camera.project(center[None])[0],
            distance,
            upright[:, 2],
            float(np.arctan2(upright[1, 0], upright[0, 0])),
        )

    @property
    def tilt(self) -> float:
        """Degrees between the board's normal and the line of sight."""
        return float(np.degrees(np.arccos(np.clip(self.normal[2], -1, 1))))


def turn_to(ray: Array) -> Array:
    """Rotation vectors (..., 3) of the shortest turns that take the optical axis to unit rays (..., 3)."""
    s = np.hypot(ray[..., 0], ray[..., 1])
    angle = np.arctan2(s, ray[..., 2]) / np.maximum(s, 1e-12)
    return np.stack([-ray[..., 1] * angle, ray[..., 0] * angle, np.zeros(s.shape)], axis=-1)


def between(seen: Placement, target: Placement, width: int) -> Hint:
    """Say what differs most between the board where it was last `seen` and its `target`; `width` in px."""
    move = np.nan_to_num((target.place - seen.place) / (MOVE * width))
    near = np.log(target.distance / max(seen.distance, 1e-9)) / NEAR
    lean = np.degrees(target.normal[:2] - seen.normal[:2]) / TILT
    turn = np.degrees(np.angle(np.exp(1j * (target.turn - seen.turn)))) / TURN
    # The picture's y axis points down; a normal that leans up means the top edge is the near one.
    ways: list[tuple[float, Code, Code]] = [
        (move[0], "right", "left"),
        (move[1], "down", "up"),
        (near, "farther", "closer"),
        (lean[0], "tilt_right", "tilt_left"),
        (lean[1], "tilt_bottom", "tilt_top"),
        (turn, "turn_clockwise", "turn_counterclockwise"),
    ]
    size, forth, back = max(ways, key=lambda way: abs(way[0]))
    return Hint.of(forth if size > 0 else back)
