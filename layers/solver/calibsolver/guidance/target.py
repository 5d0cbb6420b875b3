"""Target pose: where the user is asked to hold the board."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .. import rotation
from ..arrays import Array, frozen
from ..board import Board
from ..camera import Camera
from .candidates import distance_to_border
from .hints import TEXTS, Code, Hint, Placement, largest_difference

PIXELS = ("ids", "corners", "outline")
"""Members of a target that say how a camera sees it, not where it is."""
EDGE_SAMPLES = 12
"""Points along one edge of an outline: enough to draw a curved edge to a fraction of a pixel."""


@dataclass(frozen=True, eq=False)
class TargetPose:
    """A pose of the board and how the camera would see it.

    Attributes
    ----------
    rvec, tvec
        (3,), board -> camera, squares.
    ids
        (k,) corners that a detector finds: they and what it needs to find them are inside the image.
    corners
        (k, 2) px, where those appear.
    outline
        (m, 2) px, the board's edge, distortion included, clockwise on the board; parts outside the model's
        one-to-one domain are left out, parts outside the image are not.
    purpose
        Purpose of the view, one English phrase.
    hint, hint_code
        Hint in English and as a code (`hints.Code`): the largest difference from the last placement.
    gain
        px^2, by how much the mean square projection error over the image is predicted to fall.
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
        for name in ("rvec", "tvec", "corners", "outline"):
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
        hint = Hint.of("first")
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

    def to_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {
            "rvec": self.rvec.tolist(),
            "tvec": self.tvec.tolist(),
            "ids": list(self.ids),
            "corners": self.corners.tolist(),
            "outline": self.outline.tolist(),
            "purpose": self.purpose,
            "hint": self.hint,
            "hint_code": self.hint_code,
            "gain": self.gain,
        }

    def to_record(self) -> dict[str, Any]:
        """Plain values without the pixels, which follow from the pose and the camera: what is stored."""
        return {name: value for name, value in self.to_dict().items() if name not in PIXELS}

    def redrawn(self, board: Board, camera: Camera) -> "TargetPose":
        """Target with its pixels as `camera` sees them."""
        seen = TargetPose.seen(board, camera, rotation.matrix(self.rvec), self.tvec, self.purpose, self.gain)
        return replace(self, ids=seen.ids, corners=seen.corners, outline=seen.outline)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "TargetPose":
        """Inverse of `to_dict` and, but for the pixels, of `to_record`."""
        return cls(
            rvec=np.asarray(values["rvec"], dtype=np.float64),
            tvec=np.asarray(values["tvec"], dtype=np.float64),
            ids=tuple(values.get("ids", ())),
            corners=np.asarray(values.get("corners", ()), dtype=np.float64).reshape(-1, 2),
            outline=np.asarray(values.get("outline", ()), dtype=np.float64).reshape(-1, 2),
            purpose=str(values["purpose"]),
            hint=str(values["hint"]),
            hint_code=values["hint_code"] if values.get("hint_code") in TEXTS else "first",
            gain=float(values["gain"]),
        )


def edge_points(board: Board) -> Array:
    """Points along the board's edge, (4 * EDGE_SAMPLES, 3), board frame, clockwise from the top left."""
    start, end = board.outline, np.roll(board.outline, -1, axis=0)
    s = np.arange(EDGE_SAMPLES)[None, :, None] / EDGE_SAMPLES
    points: Array = (start[:, None, :] * (1 - s) + end[:, None, :] * s).reshape(-1, 3)
    return points
