"""A camera that is known."""

from dataclasses import dataclass
from urllib.parse import urlencode

import numpy as np
import numpy.typing as npt

from calibsolver import Camera

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """Pinhole and k1."""

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
        """Query that sets the virtual camera to this, with few frames and a quick hand, to save time."""
        lens = {"fx": self.fx, "cx": self.cx, "cy": self.cy, "k1": self.k1, "k2": 0}
        width, height = self.size
        size = {} if self.size == Truth.size else {"img_size": f"{width}x{height}"}
        return urlencode({"virtual": 1, "rate": 5, "hand": "quick"} | size | lens | more)


#: half the size, which costs a quarter
SMALL = Truth(fx=500.0, cx=319.5 + 12, cy=179.5, size=(640, 360))
