"""Hints to the user: how to move the board from its last pose to the target."""

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
"""Directions are those of the camera's image: a page that mirrors its preview swaps left and right, and the
sense of a turn."""

SHIFT_WIDTHS, LOG_DISTANCE, TILT_DEG, ROLL_DEG = 0.12, 0.15, 12.0, 20.0
"""Equally conspicuous differences: a shift / image width, a logarithm of distances, a tilt, a roll."""


@dataclass(frozen=True)
class Hint:
    """Instruction to the user."""

    code: Code

    @property
    def text(self) -> str:
        """English text of at most six words."""
        return TEXTS[self.code]


@dataclass(frozen=True, eq=False)
class Placement:
    """Placement of a board in the image, as a person describes it.

    Attributes
    ----------
    center
        (2,) px.
    distance
        Squares, of its centre from the camera.
    normal
        (3,) away from the viewer, in a frame whose z axis is the line of sight to the centre.
    roll
        Radians, clockwise in the image.
    """

    center: Array
    distance: float
    normal: Array
    roll: float

    @classmethod
    def of(cls, board: Board, camera: Camera, r: Array, t: Array) -> "Placement":
        """Placement of a board at rotation (3, 3) and translation (3,)."""
        center = r @ board.outline.mean(axis=0) + t
        distance = float(np.linalg.norm(center))
        upright = rotation.rotation_to_ray(center / distance).T @ r
        return cls(
            camera.project(center[None])[0],
            distance,
            upright[:, 2],
            float(np.arctan2(upright[1, 0], upright[0, 0])),
        )


def largest_difference(last: Placement, target: Placement, width: int) -> Hint:
    """Hint at the largest difference between the `last` placement and the `target`; image `width` in px."""
    shift = np.nan_to_num((target.center - last.center) / (SHIFT_WIDTHS * width))
    distance = np.log(target.distance / max(last.distance, 1e-9)) / LOG_DISTANCE
    tilt = np.degrees(target.normal[:2] - last.normal[:2]) / TILT_DEG
    roll = np.degrees(np.angle(np.exp(1j * (target.roll - last.roll)))) / ROLL_DEG
    # The picture's y axis points down; a normal that leans up means the top edge is the near one.
    differences: list[tuple[float, Code, Code]] = [
        (shift[0], "right", "left"),
        (shift[1], "down", "up"),
        (distance, "farther", "closer"),
        (tilt[0], "tilt_right", "tilt_left"),
        (tilt[1], "tilt_bottom", "tilt_top"),
        (roll, "turn_clockwise", "turn_counterclockwise"),
    ]
    size, positive, negative = max(differences, key=lambda difference: abs(difference[0]))
    return Hint(positive if size > 0 else negative)
