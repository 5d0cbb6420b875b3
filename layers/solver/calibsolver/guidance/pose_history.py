"""Poses of a session so far: what this user could hold, and how noisy this camera's corners were there."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import rotation
from ..arrays import Array
from ..board import Board
from ..camera import Camera
from ..fitting.calibration import Calibration
from .candidates import PoseLimits
from .hints import Placement
from .posterior import MIN_NOISE_WIDTHS
from .target import TargetPose

CLOSE_UP_WIDTH, STEEP_TILT_DEG = 0.75, 45.0
UNPROVEN_NOISE_FACTOR = 1.1
"""Noise expected beyond these, until a view has been there / noise of the best view."""
MIN_BAD_NOISE_FACTOR = 1.35
"""Noise of a view / noise of the best, from which poses like it are bad, not this one by chance."""
RETREAT = 0.8
"""Share of an unreached target's tilt or width that later targets may have."""
EASY_TILT_DEG, EASY_WIDTH = 25.0, 0.6
"""Tilt and apparent width that can always be asked for."""


@dataclass(frozen=True, eq=False)
class PoseHistory:
    """Views of a session (v), and targets not reached (m).

    Attributes
    ----------
    tilt, width, noise
        (v,) degrees; apparent length of the board's longer side / the image's; noise / that of the best view.
    unreached
        (m, 2) tilt and width.
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
        calibration: Calibration | None,
        unreached: Sequence[TargetPose],
    ) -> "PoseHistory":
        """History of a calibration's views and of targets given up, as `camera` sees them."""
        rt = np.empty((0, 6)) if calibration is None else calibration.poses
        given_up = np.array([[*t.rvec, *t.tvec] for t in unreached]).reshape(-1, 6)
        tilts_and_widths = []
        for pose in np.concatenate([rt, given_up]):
            placed = Placement.of(board, camera, rotation.matrix(pose[:3]), pose[3:])
            width = camera.focal[0] * max(board.size) / (placed.distance * max(camera.img_size))
            tilts_and_widths.append((placed.tilt, width))
        tilts, widths = np.array(tilts_and_widths).reshape(-1, 2).T
        noise = np.ones(len(rt))
        if calibration is not None:
            pairs = zip(calibration.residuals, calibration.used, strict=True)
            # Six points do not measure noise: some pose fits them. Noise below a detector's does not count.
            enough = [(i, e[u]) for i, (e, u) in enumerate(pairs) if u.sum() > 6]
            rms = np.array([np.sqrt(np.mean(np.sum(e**2, axis=1))) for _, e in enough])
            rms = np.maximum(rms, MIN_NOISE_WIDTHS * camera.img_size[0])
            noise[[i for i, _ in enough]] = rms / rms.min(initial=np.inf)
        v = len(rt)
        return cls(tilts[:v], widths[:v], noise, np.stack([tilts[v:], widths[v:]], axis=1))

    def restrict(self, limits: PoseLimits) -> PoseLimits:
        """Limits that exclude poses as hard as those not reached, unless a view has been there."""
        tilt, (low, width) = limits.max_tilt_deg, limits.width
        for t, w in self.unreached:
            # Both are reduced: it is unknown which of them was too hard.
            if t > STEEP_TILT_DEG:
                tilt = min(tilt, max(RETREAT * t, EASY_TILT_DEG, self.tilt.max(initial=0)))
            if w > CLOSE_UP_WIDTH:
                width = min(width, max(RETREAT * w, EASY_WIDTH, self.width.max(initial=0)))
        return replace(limits, max_tilt_deg=float(tilt), width=(low, float(max(width, low))))

    def expected_noise(self, tilt: Array, width: Array) -> Array:
        """Noise (c,) to expect at poses of tilts and widths (c,) / noise of the best view."""
        factor = np.ones(len(tilt))
        if self.tilt.max(initial=0) < STEEP_TILT_DEG:
            factor = np.where(tilt > STEEP_TILT_DEG, UNPROVEN_NOISE_FACTOR, factor)
        if self.width.max(initial=0) < CLOSE_UP_WIDTH:
            factor = np.where(width > CLOSE_UP_WIDTH, factor * UNPROVEN_NOISE_FACTOR, factor)
        for t, w, noise in zip(self.tilt, self.width, self.noise, strict=True):
            if noise < MIN_BAD_NOISE_FACTOR:
                continue
            steeper = (t > STEEP_TILT_DEG - 15) & (tilt > t - 5)
            closer = (w > CLOSE_UP_WIDTH) & (width > 0.9 * w)
            factor = np.where(steeper | closer, np.maximum(factor, noise), factor)
        return factor
