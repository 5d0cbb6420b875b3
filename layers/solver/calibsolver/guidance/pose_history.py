"""What a session has shown of what this user can hold and this camera can see."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import rotation
from ..arrays import Array
from ..board import Board
from ..camera import Camera
from ..fitting.calibration import Calibration
from .belief import LEAST_NOISE
from .candidates import Range
from .hints import Placement
from .target import TargetPose

WIDE, OBLIQUE = 0.75, 45.0
"""Apparent width / image, and tilt, degrees, beyond which fixed-focus lenses blur and glossy boards shine."""
UNPROVEN = 1.1
"""Times the noise that is expected beyond these until a view has shown that it holds there."""
WORSE = 1.35
"""Times the noise of the best from which a view says that its kind is bad, not that it was unlucky."""
RETREAT = 0.8
"""Share of an unreached target's tilt or width that is asked for at most afterwards."""
GENTLE_TILT, GENTLE_WIDTH = 25.0, 0.6
"""What can always be asked for."""


@dataclass(frozen=True, eq=False)
class Experience:
    """Tilt (degrees), width (board / image) and noise (1: like the best) of views; targets not reached.

    Attributes
    ----------
    tilt, width, noise
        (v,)
    unreached
        (m, 2) tilt and width of targets that were given up.
    """

    tilt: Array
    width: Array
    noise: Array
    unreached: Array

    @classmethod
    def of(
        cls,
        board: Board,
        camera: Camera,
        focal: float,
        calibration: Calibration | None,
        unreached: Sequence[TargetPose],
    ) -> "Experience":
        """Gather it from a calibration's views and from targets given up, seen by `camera` of `focal` px."""
        rt = np.empty((0, 6)) if calibration is None else calibration.poses
        given_up = np.array([[*t.rvec, *t.tvec] for t in unreached]).reshape(-1, 6)
        shapes = [
            shape(Placement.of(board, camera, rotation.matrix(pose[:3]), pose[3:]), board, focal, camera)
            for pose in np.concatenate([rt, given_up])
        ]
        tilt, width = np.array(shapes).reshape(-1, 2).T
        noise = np.ones(len(rt))
        if calibration is not None:
            pairs = zip(calibration.residuals, calibration.used, strict=True)
            # Six points say nothing: some pose fits them. Nor does noise below any detector's.
            enough = [(i, e[u]) for i, (e, u) in enumerate(pairs) if u.sum() > 6]
            seen = np.array([np.sqrt(np.mean(e**2)) for _, e in enough])
            seen = np.maximum(seen, LEAST_NOISE * camera.img_size[0])
            noise[[i for i, _ in enough]] = seen / seen.min(initial=np.inf)
        v = len(rt)
        return cls(tilt[:v], width[:v], noise, np.stack([tilt[v:], width[v:]], axis=1))

    def within(self, limits: Range) -> Range:
        """Return `limits` without what could not be reached, unless a view has reached it since."""
        tilt, (low, width) = limits.tilt, limits.width
        for t, w in self.unreached:
            # Both are drawn in: nobody says which of them it was.
            if t > OBLIQUE:
                tilt = min(tilt, max(RETREAT * t, GENTLE_TILT, self.tilt.max(initial=0)))
            if w > WIDE:
                width = min(width, max(RETREAT * w, GENTLE_WIDTH, self.width.max(initial=0)))
        return replace(limits, tilt=float(tilt), width=(low, float(max(width, low))))

    def expected_noise(self, tilt: Array, width: Array) -> Array:
        """Noise (c,) of poses of tilts and widths (c,), 1: like the best so far."""
        factor = np.ones(len(tilt))
        if self.tilt.max(initial=0) < OBLIQUE:
            factor = np.where(tilt > OBLIQUE, UNPROVEN, factor)
        if self.width.max(initial=0) < WIDE:
            factor = np.where(width > WIDE, factor * UNPROVEN, factor)
        for t, w, noise in zip(self.tilt, self.width, self.noise, strict=True):
            if noise < WORSE:
                continue
            alike = ((t > OBLIQUE - 15) & (tilt > t - 5)) | ((w > WIDE) & (width > 0.9 * w))
            factor = np.where(alike, np.maximum(factor, noise), factor)
        return factor


def shape(placement: Placement, board: Board, focal: float, camera: Camera) -> tuple[float, float]:
    """Tilt, degrees, and apparent length of the board's longer side / the image's longer side."""
    return placement.tilt, focal * max(board.size) / (placement.distance * max(camera.img_size))
