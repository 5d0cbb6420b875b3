"""Perspective plane x = X/Z, y = Y/Z, distorted: the base of OpenCV's polynomial and rational models."""

import math

import numpy as np

from ..arrays import Array
from .planar import Planar


class Pinhole(Planar):
    """A planar distortion of the perspective image; nothing next to or behind the camera is visible."""

    is_perspective = True
    max_angle = 1.4  # beyond, a degree makes a tenth of the distance from the axis and more, without bound

    def distort(self, d: Array, p: Array) -> Array:
        return self.distort_plane(d, p[0] / p[2], p[1] / p[2])

    def distort_jacobian(self, d: Array, p: Array) -> tuple[Array, Array, Array]:
        iz = 1 / p[2]
        x, y = p[0] * iz, p[1] * iz
        u, by_d, ux, uy, vy = self.distort_plane_jacobian(d, x, y)
        by_p = np.empty((3, 2, *x.shape))
        np.multiply(ux, iz, out=by_p[0, 0])
        np.multiply(uy, iz, out=by_p[0, 1])
        by_p[1, 0] = by_p[0, 1]
        np.multiply(vy, iz, out=by_p[1, 1])
        by_p[2] = -(x * by_p[0] + y * by_p[1])
        return u, by_d, by_p

    def domain_half_angle(self, d: Array) -> float:
        return math.atan(self.domain_radius(d))

    def undistort(self, d: Array, u: Array) -> Array:
        x, y = self.undistort_plane(d, u)
        norm = np.sqrt(1 + x * x + y * y)
        return np.stack([x / norm, y / norm, 1 / norm])
