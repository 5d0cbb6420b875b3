"""OpenCV's 5-coefficient model of lenses that keep straight lines nearly straight: k1 k2 p1 p2 k3.

x = X/Z, y = Y/Z, s = x^2 + y^2, g = 1 + k1 s + k2 s^2 + k3 s^3, and the tangential part of `planar`
(OpenCV documentation, "Camera Calibration and 3D Reconstruction"; after Brown 1971).
"""

import math

from ..arrays import Array
from .base import Coefficient, Prior, first_root
from .pinhole import Pinhole
from .planar import MAX_RADIUS, MIN_TANGENTIAL_RATIO


class Rectilinear(Pinhole):
    """OpenCV's 5-coefficient model (formula: see the module)."""

    name = "rectilinear"
    coefficients = ("k1", "k2", "p1", "p2", "k3")
    radial_at = (0, 1, 4)
    tangential_at = (2, 3)
    prior = Prior(
        focal=0.8,
        focal_sigma=0.5,
        distortion=(
            Coefficient(0.5, 1, 0.4),
            Coefficient(2.0, 2, 0.3),
            Coefficient(0.006),
            Coefficient(0.006),
            Coefficient(5.0, 3, 0.3),
        ),
    )
    start_focals = (0.35, 0.5, 0.7, 0.95, 1.3, 1.9, 2.8)

    def radial(self, d: Array, s: Array) -> Array:
        g: Array = 1 + s * (d[0] + s * (d[1] + s * d[4]))
        return g

    def radial_jacobian(self, d: Array, s: Array) -> tuple[Array, Array, tuple[Array, ...]]:
        s2 = s * s
        return self.radial(d, s), d[0] + s * (2 * d[1] + 3 * d[4] * s), (s, s2, s2 * s)

    def domain_radius(self, d: Array) -> float:
        """Radius up to which the radial part grows: beyond it the image would fold."""
        k1, k2, p1, p2, k3 = (float(c) for c in d)
        return first_root(
            (-MIN_TANGENTIAL_RATIO * math.hypot(p1, p2), 3 * k1, 0.0, 5 * k2, 0.0, 7 * k3), MAX_RADIUS
        )
