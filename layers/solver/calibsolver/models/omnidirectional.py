"""The unified model of mirrors and very wide lenses as in cv2.omnidir, zero skew: xi k1 k2 p1 p2.

A point goes to the unit sphere, then to a plane seen from xi behind the sphere's centre:
x = X / (Z + xi |p|), y = Y / (Z + xi |p|), then g = 1 + k1 s + k2 s^2 and the tangential part of `planar`
(Geyer & Daniilidis 2000; Mei & Rives 2007; OpenCV documentation, "Omnidirectional Camera Calibration").
fx, fy are the generalised focal lengths: at the axis a lens magnifies by fx / (1 + xi).
"""

import math

import numpy as np

from ..arrays import Array
from .base import Coefficient, Prior, first_root
from .planar import MAX_RADIUS, MIN_TANGENTIAL_RATIO, Planar


class Omnidirectional(Planar):
    """Unified model as in cv2.omnidir."""

    name = "omnidirectional"
    coefficients = ("xi", "k1", "k2", "p1", "p2")
    start_families = 2
    radial_at = (1, 2)
    tangential_at = (3, 4)
    prior = Prior(
        focal=0.6,
        focal_sigma=0.6,
        distortion=(
            Coefficient(0.7, mean=1.0),
            Coefficient(0.5, 1, 0.4),
            Coefficient(1.0, 2, 0.4),
            Coefficient(0.01),
            Coefficient(0.01),
        ),
    )
    start_focals = (0.2, 0.28, 0.38, 0.52, 0.72, 1.0, 1.4, 1.9, 2.5)

    def radial(self, d: Array, s: Array) -> Array:
        g: Array = 1 + s * (d[1] + s * d[2])
        return g

    def radial_jacobian(self, d: Array, s: Array) -> tuple[Array, Array, tuple[Array, ...]]:
        return self.radial(d, s), d[1] + 2 * d[2] * s, (s, s * s)

    def domain_radius(self, d: Array) -> float:
        """Radius up to which the radial part grows, and the sphere's rays are distinguished."""
        xi, k1, k2, p1, p2 = (float(c) for c in d)
        edge = first_root((-MIN_TANGENTIAL_RATIO * math.hypot(p1, p2), 3 * k1, 0.0, 5 * k2), MAX_RADIUS)
        return min(edge, 1 / math.sqrt(xi * xi - 1)) if xi > 1 else edge

    def domain_half_angle(self, d: Array) -> float:
        xi, limit = float(d[0]), self.domain_radius(d)
        if not -1 < xi < math.inf:
            return 0.0
        along = float(distance(xi, np.array(limit * limit)))
        return math.atan2(limit * along, along - xi)

    def distort(self, d: Array, p: Array) -> Array:
        below = 1 / (p[2] + d[0] * np.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]))
        return self.distort_plane(d, p[0] * below, p[1] * below)

    def distort_jacobian(self, d: Array, p: Array) -> tuple[Array, Array, Array]:
        length = np.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
        below = 1 / (p[2] + d[0] * length)
        x, y = p[0] * below, p[1] * below
        u, by_d, ux, uy, vy = self.distort_plane_jacobian(d, x, y)
        # d(x, y)/dp = below (dX, dY) - (x, y) below (dZ + xi d|p|)
        ux, uy, vy = ux * below, uy * below, vy * below
        moved = np.stack([x * ux + y * uy, x * uy + y * vy])
        by_d[0] = -moved * length
        turn = p * (d[0] / length)
        turn[2] += 1
        by_p = -moved * turn[:, None]
        by_p[0, 0] += ux
        by_p[0, 1] += uy
        by_p[1, 0] += uy
        by_p[1, 1] += vy
        return u, by_d, by_p

    def undistort(self, d: Array, u: Array) -> Array:
        """Undistort the plane, then lift to the sphere in closed form (Mei & Rives 2007, eq. 4)."""
        x, y = self.undistort_plane(d, u)
        with np.errstate(invalid="ignore"):
            along = distance(float(d[0]), x * x + y * y)
        return np.stack([x * along, y * along, along - d[0]])

    def magnification(self, d: Array) -> tuple[float, Array]:
        by = np.zeros(5)
        by[0] = -1 / (1 + d[0]) ** 2
        return float(1 / (1 + d[0])), by

    def start(self, focal: float, img_size: tuple[int, int]) -> Array:
        """Intrinsics in the middle of lenses and mirrors, xi = 1."""
        return self._start(1.0, focal, img_size)

    def initial_intrinsics(self, img_size: tuple[int, int]) -> list[Array]:
        """Stereographic images, and ones that shrink towards the rim."""
        return [self._start(xi, f * img_size[0], img_size) for xi in (1.0, 2.5) for f in self.start_focals]

    def _start(self, xi: float, focal: float, img_size: tuple[int, int]) -> Array:
        k = super().start((1 + xi) * focal, img_size)
        k[4] = xi
        return k


def distance(xi: float, s: Array) -> Array:
    """Distance to the unit sphere along the ray (x, y, 1), in its units; s = x^2 + y^2."""
    return (xi + np.sqrt(np.maximum(1 + (1 - xi * xi) * s, 0.0))) / (1 + s)
