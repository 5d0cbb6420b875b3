"""A camera that is known, and how far an estimate is from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from urllib.parse import urlencode

import cv2
import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """Pinhole and k1, at 1280 x 720; the rest of the distortion is nought."""

    fx: float = 1000.0
    cx: float = 639.5 + 25
    cy: float = 359.5
    k1: float = -0.25
    size: tuple[int, int] = (1280, 720)

    @property
    def matrix(self) -> Array:
        return np.array([[self.fx, 0, self.cx], [0, self.fx, self.cy], [0, 0, 1.0]])

    @property
    def distortion(self) -> Array:
        return np.array([self.k1, 0, 0, 0, 0.0])

    def query(self, **more: object) -> str:
        """Address part that sets the virtual camera to this.

        Its pictures are fewer than a real camera's, and who holds the board is quick: both take a machine's
        time, and nobody watches.
        """
        lens = {"fx": self.fx, "cx": self.cx, "cy": self.cy, "k1": self.k1, "k2": 0}
        width, height = self.size
        size = {} if self.size == Truth.size else {"img_size": f"{width}x{height}"}
        return urlencode({"virtual": 1, "rate": 5, "hand": "quick"} | size | lens | more)


#: at half the size, which costs a quarter: for what does not depend on the number of pixels
SMALL = Truth(fx=500.0, cx=319.5 + 12, cy=179.5, size=(640, 360))


def projection_errors(truth: Truth, calibration: dict[str, Any], grid: tuple[int, int] = (20, 15)) -> Array:
    """Distance of true and estimated projection of the same rays after the best rotation, px, (points,).

    At the centres of cells, where a calibration states its error (`Calibration.projection_std`): in the very
    corner these lenses are about to fold, and a ray there is worth a dozen pixels. A turn of the camera frame
    is no error: a user of the calibration cannot tell it from a turned camera.
    """
    columns, rows = grid
    across = (np.arange(columns) + 0.5) * truth.size[0] / columns - 0.5
    down = (np.arange(rows) + 0.5) * truth.size[1] / rows - 0.5
    u, v = np.meshgrid(across, down)
    q = np.stack([u.ravel(), v.ravel()], axis=1)
    exact = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 200, 1e-12)
    xy = cv2.undistortPoints(q[:, None], truth.matrix, truth.distortion, criteria=exact).reshape(-1, 2)
    rays = np.column_stack([xy, np.ones(len(xy))])
    k = np.array(calibration["camera_matrix"], dtype=float)
    d = np.array(calibration["distortion_coefficients"], dtype=float)

    def residual(turn: Array) -> Array:
        seen = cv2.projectPoints(rays, turn, np.zeros(3), k, d)[0].reshape(-1, 2)
        return np.asarray(seen - q, dtype=np.float64)

    turn = np.zeros(3)
    for _ in range(5):  # Gauss-Newton; the Jacobian of three small angles by differences
        base = residual(turn).ravel()
        step = 1e-6
        jacobian = np.stack(
            [(residual(turn + step * axis).ravel() - base) / step for axis in np.eye(3)], axis=1
        )
        turn = turn - np.linalg.lstsq(jacobian, base, rcond=None)[0]
    return np.asarray(np.linalg.norm(residual(turn), axis=1))
