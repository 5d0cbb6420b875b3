"""The perspective plane x = X/Z, y = Y/Z, distorted: what OpenCV's polynomial and rational models share."""

import math

import numpy as np

from ..arrays import Array
from .planar import Planar


class Pinhole(Planar):
    """A planar distortion of the perspective image; nothing beside or behind the camera is seen."""

    straight = True
    widest = 1.4  # beyond, a degree makes a tenth of the distance from the axis and more, without bound

    def distort(self, d: Array, p: Array) -> Array:
        """See `Model.distort`."""
        return self.bend(d, p[0] / p[2], p[1] / p[2])

    def distort_jacobian(self, d: Array, p: Array) -> tuple[Array, Array, Array]:
        """See `Model.distort_jacobian`."""
        iz = 1 / p[2]
        x, y = p[0] * iz, p[1] * iz
        u, by_d, ux, uy, vy = self.bend_jacobian(d, x, y)
        by_p = np.empty((3, 2, *x.shape))
        np.multiply(ux, iz, out=by_p[0, 0])
        np.multiply(uy, iz, out=by_p[0, 1])
        by_p[1, 0] = by_p[0, 1]
        np.multiply(vy, iz, out=by_p[1, 1])
        by_p[2] = -(x * by_p[0] + y * by_p[1])
        return u, by_d, by_p

    def angle(self, d: Array) -> float:
        """See `Model.angle`."""
        return math.atan(self.limit(d))

    def undistort(self, d: Array, u: Array) -> Array:
        """See `Model.undistort`."""
        x, y = self.flatten(d, u)
        norm = np.sqrt(1 + x * x + y * y)
        return np.stack([x / norm, y / norm, 1 / norm])
