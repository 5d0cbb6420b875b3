"""Shape of a board that is not as drawn: a bend, and a print that stretched.

Paper bends, and printers stretch. Both are the same in all views of a capture, so enough views distinguish
them from the lens by five parameters (Strobl & Hirzinger, "More accurate pinhole camera calibration with
imperfect planar target", ICCV workshops 2011, free every point instead). Their variance is learnt
(`mixed_model`), so that a flat board costs nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from ..arrays import Array
from ..view import View
from .mixed_model import SHAPE_SIZE
from .observations import Observations
from .systematic_effects import BEND_SIZE

MAX_STRETCH = 0.01
"""Stretch that a printer may cause; a larger one is rather the lens or the shutter."""
HEIGHT_GRID = np.linspace(-1, 1, 9)


@dataclass(frozen=True, eq=False)
class BoardShape:
    """Deviation of a board from its drawing.

    Attributes
    ----------
    center, half
        Middle of the corners (x, y) and half their longer extent, board units.
    reach
        Half the extent of the corners along x and y / the longer of them.
    parameters
        Heights of x^2, xy and y^2 where x and y are 1 at half a longer side from the middle, / longer extent;
        then the relative stretch of x (y shrinks by the same) and the shear of x by y.
    covariance
        (SHAPE_SIZE, SHAPE_SIZE) of the parameters.
    """

    center: tuple[float, float]
    half: float
    reach: tuple[float, float]
    parameters: tuple[float, ...] = (0.0,) * SHAPE_SIZE
    covariance: Array = field(default_factory=lambda: np.zeros((SHAPE_SIZE, SHAPE_SIZE)))

    @classmethod
    def of(cls, obs: Observations) -> "BoardShape":
        """Shape of a board as drawn, of all that was seen of it."""
        low, high = obs.points.min(axis=(0, 2)), obs.points.max(axis=(0, 2))
        x, y = ((low + high) / 2)[:2].tolist()
        width, height = (high - low)[:2].tolist()
        longer = max(width, height)
        return cls((x, y), longer / 2, (width / longer, height / longer))

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> "BoardShape":
        """Shape of a `record`, without its covariance."""
        (x, y), (wide, high) = record["center"], record["reach"]
        return cls((x, y), record["half"], (wide, high), tuple(record["parameters"]))

    def record(self) -> dict[str, Any]:
        """Parameters and frame as plain values."""
        return {
            "center": list(self.center),
            "half": self.half,
            "reach": list(self.reach),
            "parameters": list(self.parameters),
        }

    def figures(self) -> dict[str, float | str]:
        """Sag and stretch with their standard deviations, as a calibration's record has them."""
        return {
            "sag": self.sag,
            "sag_std": self.sag_std,
            "stretch": self.stretch,
            "stretch_std": self.stretch_std,
            "stretch_kind": self.stretch_kind,
        }

    @property
    def sag(self) -> float:
        """Largest height over the plane that fits best / longer extent of the corners."""
        return self._largest(self._off_plane)[0]

    @property
    def sag_std(self) -> float:
        """Standard deviation of `sag`."""
        return self._largest(self._off_plane)[1]

    @property
    def stretch(self) -> float:
        """Error of the print: the larger of stretch (width against height) and shear, as a share."""
        return self._largest(self._print)[0]

    @property
    def stretch_std(self) -> float:
        """Standard deviation of `stretch`."""
        return self._largest(self._print)[1]

    @property
    def stretch_kind(self) -> Literal["wider", "narrower", "skewed"]:
        """Kind of error that `stretch` measures."""
        width, shear = self._print @ self.parameters
        if abs(shear) > abs(width):
            return "skewed"
        return "wider" if width > 0 else "narrower"

    @property
    def is_plausible(self) -> bool:
        """True if a printer may have stretched the board so."""
        return self.stretch <= MAX_STRETCH

    @cached_property
    def _off_plane(self) -> Array:
        """Derivatives (m, SHAPE_SIZE) of the heights over the best plane by the parameters."""
        x, y = (c.ravel() for c in np.meshgrid(self.reach[0] * HEIGHT_GRID, self.reach[1] * HEIGHT_GRID))
        height = np.stack([x * x, x * y, y * y], axis=1)
        plane = np.stack([x, y, np.ones_like(x)], axis=1)
        height -= plane @ np.linalg.lstsq(plane, height, rcond=None)[0]
        return np.concatenate([height, np.zeros((len(height), SHAPE_SIZE - BEND_SIZE))], axis=1)

    @property
    def _print(self) -> Array:
        """Derivatives (2, SHAPE_SIZE) of stretch and shear by the parameters."""
        return np.diag([0.0, 0.0, 0.0, 2.0, 1.0])[BEND_SIZE:]

    def _largest(self, gradients: Array) -> tuple[float, float]:
        """Largest number of these gradients (m, SHAPE_SIZE), and its standard deviation."""
        numbers = np.abs(gradients @ self.parameters)
        gradient = gradients[int(np.argmax(numbers))]
        variance = float(gradient @ self.covariance @ gradient)
        return float(numbers.max()), float(np.sqrt(max(variance, 0.0)))

    def displacements(self, points: Array) -> Array:
        """Derivatives (SHAPE_SIZE, 3, ...) of points (3, ...), board frame, by the parameters."""
        x = (points[0] - self.center[0]) / self.half
        y = (points[1] - self.center[1]) / self.half
        out = np.zeros((SHAPE_SIZE, *points.shape))
        out[0, 2], out[1, 2], out[2, 2] = x * x, x * y, y * y
        out[:3] *= 2 * self.half
        out[3, 0], out[3, 1], out[4, 0] = x * self.half, -y * self.half, y * self.half
        return out

    def moved(self, points: Array) -> Array:
        """Points (3, ...), board frame, of the board in this shape."""
        return points + np.tensordot(np.array(self.parameters), self.displacements(points), axes=1)

    def apply(self, view: View) -> View:
        """View of the board in this shape."""
        return replace(view, object_points=self.moved(view.object_points.T).T)
