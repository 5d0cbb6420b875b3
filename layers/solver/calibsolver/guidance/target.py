"""Target pose: where the user is asked to hold the board."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from .. import models, rotation
from ..arrays import Array, frozen
from ..board import Board
from ..camera import Camera
from .candidates import distance_to_border
from .hints import TEXTS, Code, Hint, Placement, largest_difference

ARRAYS = ("rvec", "tvec", "corners", "outline")
EDGE_SAMPLES = 12
"""Points along one edge of an outline: enough to draw a curved edge to a fraction of a pixel."""


@dataclass(frozen=True, eq=False)
class TargetPose:
    """Pose of the board, where the user is asked to hold it, and how the camera would see it.

    Attributes
    ----------
    rvec, tvec
        (3,), board -> camera, squares.
    ids
        (k,) corners that a detector finds: they and what it needs to find them are inside the image.
    corners
        (k, 2) px, where those appear.
    outline
        (m, 2) px, the board's edge, clockwise on the board, also outside the image, but not outside the
        model's one-to-one domain.
    purpose
        One English phrase.
    hint, hint_code
        The largest difference from the last placement.
    gain
        px^2, predicted decrease of the mean square projection error over the image.
    """

    rvec: Array
    tvec: Array
    ids: tuple[int, ...]
    corners: Array
    outline: Array
    purpose: str
    hint: str
    hint_code: Code
    gain: float

    def __post_init__(self) -> None:
        for name in ARRAYS:
            object.__setattr__(self, name, frozen(getattr(self, name)))
        object.__setattr__(self, "ids", tuple(int(i) for i in self.ids))

    @classmethod
    def seen(
        cls,
        board: Board,
        camera: Camera,
        r: Array,
        t: Array,
        purpose: str,
        gain: float,
        last: Placement | None = None,
    ) -> "TargetPose":
        """Target at rotation (3, 3) and translation (3,) as `camera` sees it; `last`: last placement."""
        q = camera.project(board.points @ r.T + t)
        support = camera.project(board.support.reshape(-1, 3) @ r.T + t).reshape(*board.support.shape[:3], 2)
        whole = np.all(distance_to_border(support, camera.img_size) >= 0, axis=2)
        inside = (distance_to_border(q, camera.img_size) >= 0) & np.any(whole, axis=1)
        edge = camera.project(edge_points(board) @ r.T + t)
        hint = Hint("first")
        if last is not None:
            hint = largest_difference(last, Placement.of(board, camera, r, t), camera.img_size[0])
        return cls(
            rvec=rotation.vector(r),
            tvec=t,
            ids=tuple(np.flatnonzero(inside)),
            corners=q[inside],
            outline=edge[np.isfinite(edge[:, 0])],
            purpose=purpose,
            hint=hint.text,
            hint_code=hint.code,
            gain=gain,
        )

    @property
    def r(self) -> Array:
        """Rotation (3, 3), board -> camera."""
        return rotation.matrix(self.rvec)

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        arrays = {name: values[name].tolist() for name in ARRAYS}
        return {**values, **arrays, "ids": list(self.ids)}

    def to_record(self) -> dict[str, Any]:
        """Plain values without the pixels, which follow from the pose and the camera."""
        pixels = ("ids", "corners", "outline")
        return {name: value for name, value in self.to_dict().items() if name not in pixels}

    def redrawn(self, board: Board, camera: Camera) -> "TargetPose":
        """Target with its pixels as `camera` sees them."""
        seen = TargetPose.seen(board, camera, self.r, self.tvec, self.purpose, self.gain)
        return replace(self, ids=seen.ids, corners=seen.corners, outline=seen.outline)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "TargetPose":
        """Target of `to_dict` or, without the pixels, of `to_record`."""
        return cls(
            rvec=values["rvec"],
            tvec=values["tvec"],
            ids=tuple(values.get("ids", ())),
            corners=np.reshape(values.get("corners", ()), (-1, 2)),
            outline=np.reshape(values.get("outline", ()), (-1, 2)),
            purpose=str(values["purpose"]),
            hint=str(values["hint"]),
            hint_code=values["hint_code"] if values.get("hint_code") in TEXTS else "first",
            gain=float(values["gain"]),
        )


class Guide:
    """Chooser of target poses. `seed`: camera that others have measured."""

    def __init__(
        self,
        board: Board,
        img_size: tuple[int, int],
        model: str = "rectilinear",
        seed: Camera | None = None,
    ) -> None:
        self.board = board
        self.img_size = (int(img_size[0]), int(img_size[1]))
        self.model = models.get(model)
        self.seed = seed


def edge_points(board: Board) -> Array:
    """Points along the board's edge, (4 * EDGE_SAMPLES, 3), board frame, clockwise from the top left."""
    start, end = board.outline, np.roll(board.outline, -1, axis=0)
    s = np.arange(EDGE_SAMPLES)[None, :, None] / EDGE_SAMPLES
    return np.asarray((start[:, None, :] * (1 - s) + end[:, None, :] * s).reshape(-1, 3))
