"""Stillness of the board, from its corners frame by frame, by the rules of the capture page."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..detection import Corners

MAX_MOTION_PX = 2.0
"""Motion between two frames, at 1280 px image width, mean over the corners, up to which a board is still."""
MAX_DRIFT_PX = 6.0
"""Distance from where the hold began: slow movement is movement."""
MAX_GAP_S = 0.15
"""Time for which frames may be smeared, or show nothing, before the hold is over."""
MIN_COMMON_CORNERS = 4
REFERENCE_WIDTH_PX = 1280.0


@dataclass(frozen=True, eq=False)
class Stillness:
    """Hold of the board: corners and seconds where it began, and of the last frame that counted.

    `frames` counts neither the first frame nor repeated ones.
    """

    anchor: Corners | None = None
    last: Corners | None = None
    since: float = 0.0
    seen: float = field(default=float("-inf"))
    frames: int = 0

    @property
    def held(self) -> float:
        """Seconds for which the board has been held."""
        return self.seen - self.since if self.frames or self.anchor else 0.0

    def observe(
        self, corners: Corners | None, time: float, width: int, lenience: float = 1.0, repeated: bool = False
    ) -> Stillness:
        """Return the hold after one more frame; the same one if the frame says nothing.

        `lenience` is the factor on a steady hand's motion that still counts as still.
        """
        scale = lenience * width / REFERENCE_WIDTH_PX
        if corners is not None and self.anchor is not None and self.last is not None:
            near = motion(self.last, corners) < MAX_MOTION_PX * scale
            if near and motion(self.anchor, corners) < MAX_DRIFT_PX * scale:
                return Stillness(self.anchor, corners, self.since, time, self.frames + (not repeated))
        if self.frames and time - self.seen < MAX_GAP_S:
            return self
        if corners is None:
            return Stillness()
        return Stillness(corners, corners, time, time, 0)


def motion(one: Corners, other: Corners) -> float:
    """Mean distance of the corners seen in both, px; infinite where too few are."""
    places = dict(zip(other.ids, other.points, strict=True))
    common = [(point, places[n]) for n, point in zip(one.ids, one.points, strict=True) if n in places]
    if len(common) < MIN_COMMON_CORNERS:
        return float("inf")
    a, b = np.array([each[0] for each in common]), np.array([each[1] for each in common])
    return float(np.linalg.norm(a - b, axis=1).mean())
