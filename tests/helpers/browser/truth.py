"""A camera that is known."""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import urlencode

import numpy as np
import numpy.typing as npt

from calibsolver import Camera

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

    @property
    def camera(self) -> Camera:
        return Camera("rectilinear", self.matrix, self.distortion, self.size)

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
