"""Radial and tangential distortion of a plane, which several models share.

With s = x^2 + y^2 and a radial factor g(s), u = x g + 2 p1 x y + p2 (s + 2 x^2), v = y g + p1 (s + 2 y^2) +
2 p2 x y (OpenCV documentation, "Camera Calibration and 3D Reconstruction"; after Brown 1971).

The field is a gradient: its Jacobian is symmetric. Along and across the radius that is diag(h, g) + r P M,
h = g + 2 s dg/ds, P = |(p1, p2)|, and the eigenvalues of M are between -6 and 6. Where h > 7 r P from the
axis out to a radius, g = mean(h) > 3.5 r P there too, the Jacobian is positive definite on the whole disc,
and the gradient of a strictly convex function takes no value twice.
"""

import math
from abc import abstractmethod

import numpy as np

from ..arrays import Array
from .base import Model

MAX_RADIUS = 50.0
"""Largest distance from the axis, in focal lengths."""
LAST_STEP = 1e-9
"""Newton step below which the next, about its square, is rounding."""
MAX_STEPS = 20
"""Newton's method settles in four or five steps except at the edge of the domain."""
MIN_TANGENTIAL_RATIO = 7.0
"""h / (r P) above which the map is one-to-one."""


class Planar(Model):
    """A model that ends with a radial and tangential distortion of a plane.

    `radial_at` and `tangential_at` are the places of their coefficients in `d`.
    """

    radial_at: tuple[int, ...]
    tangential_at: tuple[int, int]

    @abstractmethod
    def radial(self, d: Array, s: Array) -> Array:
        """Radial factor g at squared radii s (...)."""

    @abstractmethod
    def radial_jacobian(self, d: Array, s: Array) -> tuple[Array, Array, tuple[Array, ...]]:
        """g, dg/ds and dg/dc for each radial coefficient c, all (...)."""

    @abstractmethod
    def domain_radius(self, d: Array) -> float:
        """Radius on the plane up to which the distortion is one-to-one."""

    def distort_plane(self, d: Array, x: Array, y: Array) -> Array:
        """Distort points of the plane: (2, ...)."""
        p1, p2 = d[self.tangential_at[0]], d[self.tangential_at[1]]
        s = x * x + y * y
        g = self.radial(d, s)
        along = 2 * (p2 * x + p1 * y) + g
        return np.array([x * along + p2 * s, y * along + p1 * s])

    def distort_plane_jacobian(
        self, d: Array, x: Array, y: Array
    ) -> tuple[Array, Array, Array, Array, Array]:
        """`distort_plane` (2, ...), its derivatives by d (m, 2, ...), and ux, uy = vx, vy (...)."""
        i, j = self.tangential_at
        xx, yy, xy2 = x * x, y * y, 2 * x * y
        s = xx + yy
        g, slope, by_radial = self.radial_jacobian(d, s)
        by_d, xy = np.empty((len(d), 2, *x.shape)), np.empty((2, *x.shape))
        xy[0], xy[1] = x, y
        for at, by in zip(self.radial_at, by_radial, strict=True):
            np.multiply(xy, by, out=by_d[at])
        by_d[i, 0] = by_d[j, 1] = xy2
        np.add(s, 2 * yy, out=by_d[i, 1])
        np.add(s, 2 * xx, out=by_d[j, 0])
        u, ux, uy, vy = self._derivatives(d, (x, y), (xx, yy, xy2, s), (g, slope))
        return u, by_d, ux, uy, vy

    def _derivatives(
        self, d: Array, xy: tuple[Array, Array], squares: tuple[Array, ...], radial: tuple[Array, Array]
    ) -> tuple[Array, Array, Array, Array]:
        """`distort_plane` (2, ...) and ux, uy = vx, vy (...), from x^2, y^2, 2xy, s, and g and dg/ds."""
        (x, y), (xx, yy, xy2, s), (g, slope) = xy, squares, radial
        p1, p2 = d[self.tangential_at[0]], d[self.tangential_at[1]]
        p2x, p1y = (2 * p2) * x, (2 * p1) * y
        along = p2x + p1y
        along += g
        u = np.empty((2, *x.shape))
        np.add(x * along, p2 * s, out=u[0])
        np.add(y * along, p1 * s, out=u[1])
        uy = xy2 * slope
        slope = 2 * slope
        ux, vy = xx * slope, yy * slope
        for by, tangential in ((ux, p2x), (vy, p1y)):
            by += along
            tangential *= 2
            by += tangential
        uy += (2 * p1) * x
        uy += (2 * p2) * y
        return u, ux, uy, vy

    def undistort_plane(self, d: Array, u: Array) -> tuple[Array, Array]:
        """Invert `distort_plane`: x and y (...) of (2, ...); NaN outside the image of the one-to-one domain.

        Newton's method from the inverse of the radial part.
        """
        if not d[list(self.radial_at + self.tangential_at)].any():
            inside = np.hypot(u[0], u[1]) < self.domain_radius(d)
            return np.where(inside, u[0], np.nan), np.where(inside, u[1], np.nan)
        with np.errstate(all="ignore"):  # what runs away outside the domain is found and refused below
            limit = self.domain_radius(d)
            # Dense near the axis where the image is, and still out to the limit.
            r = np.tan(np.linspace(0, np.arctan(limit), 513)[:-1])
            table = r * self.radial(d, r * r)
            # The tangential part moves points by at most 3 P r^2. A pole at the limit reaches everywhere.
            reach = 1.01 * abs(limit * float(self.radial(d, np.array(limit * limit))))
            tangential = float(np.hypot(*d[list(self.tangential_at)]))
            length = np.hypot(u[0], u[1])
            inside = np.isfinite(length) & (length < reach + 3 * tangential * limit * limit)
            target = np.where(inside, u, 0.0)
            length = np.where(inside, length, 0.0)
            scale = np.interp(length, table, r) / np.where(length > 1e-12, length, 1.0)
            xy = target * np.where(length > 1e-12, scale, 1.0)
            self._solve_plane(d, xy.reshape(2, -1), target.reshape(2, -1), limit)
            x, y = xy
            error = np.hypot(*(self.distort_plane(d, x, y) - target))
            good = inside & (error < 1e-13 * (1 + np.hypot(*target))) & (np.hypot(x, y) < limit)
        return np.where(good, x, np.nan), np.where(good, y, np.nan)

    def _solve_plane(self, d: Array, xy: Array, target: Array, limit: float) -> None:
        """Move points (2, n) of the plane, in place, to where they are distorted to the target (2, n).

        Points that have settled are left out of Newton's steps: the few outside of the domain never do.
        """
        x, y = xy
        index = np.arange(x.size)
        for _ in range(MAX_STEPS):
            xx, yy = x * x, y * y
            s = xx + yy
            g, slope, _ = self.radial_jacobian(d, s)
            value, a, b, c = self._derivatives(d, (x, y), (xx, yy, 2 * x * y, s), (g, slope))
            e = value - target
            det = a * c - b * b
            dx, dy = (c * e[0] - b * e[1]) / det, (a * e[1] - b * e[0]) / det
            # A step across the edge ends before it: beyond, another ray may meet the same pixel.
            most = (np.sqrt(s) + 7 * limit) / 8
            length = np.hypot(x - dx, y - dy)
            if (length > most).any():
                back = np.minimum(most / length, 1)
                dx, dy = x - back * (x - dx), y - back * (y - dy)
            x, y = x - dx, y - dy
            moving = np.flatnonzero(np.abs(dx) + np.abs(dy) >= LAST_STEP)
            if 2 * moving.size < x.size:
                xy[:, index] = x, y
                x, y, target, index = x[moving], y[moving], target[:, moving], index[moving]
                if not index.size:
                    return
        xy[:, index] = x, y


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
