"""Real hands and boards: a hand that moves while the rows are read out, and a board of paper that bends."""

from dataclasses import dataclass

import numpy as np

from calibsolver import Board, Camera
from calibsolver import rotation as rotations

SQUARE_CM = 3.0
"""A board of 9 x 6 squares on a sheet of A4."""


@dataclass(frozen=True)
class Hand:
    """Motion during one frame, and the shape of the board.

    `readout_s`: from the first to the last row of an image. `speed_cm_s`, `turn_deg_s`: root mean square
    velocity of the board along and about each axis. `sag_boards`: largest height of the board / its
    longer side, the same in all views of a capture. `focal_share`: root mean square change of the focal
    length between views / the focal length, by autofocus.
    """

    readout_s: float = 0.0
    speed_cm_s: float = 0.0
    turn_deg_s: float = 0.0
    sag_boards: float = 0.0
    focal_share: float = 0.0

    def refocused(self, camera: Camera, rng: np.random.Generator) -> Camera:
        """Camera as it is focused in one view."""
        if not self.focal_share:
            return camera
        matrix = camera.matrix.copy()
        matrix[:2, :2] *= 1 + self.focal_share * rng.normal()
        return Camera(camera.model, matrix, camera.distortion, camera.img_size)

    def bend(self, board: Board, rng: np.random.Generator) -> np.ndarray:
        """Corners (n, 3) of a board bent in some direction, board frame."""
        if not self.sag_boards:
            return board.points
        center, half = board.outline.mean(axis=0), max(board.size) / 2
        x, y = ((board.points - center) / half)[:, :2].T
        height = np.stack([x * x, x * y, y * y], axis=1) @ rng.normal(size=3)
        height -= height.mean()
        points = board.points.copy()
        points[:, 2] = height * (self.sag_boards * max(board.size) / max(np.abs(height).max(), 1e-12))
        return points

    def project(
        self, points: np.ndarray, camera: Camera, rvec: np.ndarray, tvec: np.ndarray, rng: np.random.Generator
    ) -> np.ndarray:
        """Pixels (n, 2) of points (n, 3) of a board that moves at a constant velocity through the frame."""
        r = rotations.matrix(rvec)
        shift = self.speed_cm_s / SQUARE_CM * rng.normal(size=3)
        turn = np.radians(self.turn_deg_s) * rng.normal(size=3)
        center = points.mean(axis=0)
        q: np.ndarray = camera.project(points @ r.T + tvec)
        for _ in range(2):  # a point is seen when its row is read
            share = np.nan_to_num(np.clip(q[:, 1] / camera.img_size[1], 0, 1)) - 0.5
            late = (self.readout_s * share)[:, None]
            moved = np.einsum("nij,nj->ni", rotations.matrix(late * turn), (points - center) @ r.T)
            q = camera.project(moved + center @ r.T + tvec + late * shift)
        return q


STEADY = Hand()
MOVING = Hand(readout_s=0.02, speed_cm_s=5.0, turn_deg_s=10.0)
BENT = Hand(sag_boards=0.005)
REFOCUSING = Hand(focal_share=0.02)
MOVING_AND_BENT = Hand(readout_s=0.02, speed_cm_s=5.0, turn_deg_s=10.0, sag_boards=0.005)
