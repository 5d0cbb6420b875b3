"""OpenCV's 5-coefficient model of lenses that keep straight lines nearly straight: k1 k2 p1 p2 k3.

x = X/Z, y = Y/Z, s = x^2 + y^2, g = 1 + k1 s + k2 s^2 + k3 s^3,
u = x g + 2 p1 x y + p2 (s + 2 x^2),  v = y g + p1 (s + 2 y^2) + 2 p2 x y
(OpenCV documentation, "Camera Calibration and 3D Reconstruction"; after Brown 1971).
"""

import numpy as np

from ..arrays import Array, Mask
from .base import Coefficient, Model, Prior, first_root

MAX_RADIUS = 50.0
"""tan of the largest angle from the axis, about 88.9 degrees, at which the model is used."""


class Rectilinear(Model):
    """See the module's docstring."""

    name = "rectilinear"
    coefficients = ("k1", "k2", "p1", "p2", "k3")
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
    ladder = (0.35, 0.5, 0.7, 0.95, 1.3, 1.9, 2.8)

    def distort(self, d: Array, p: Array) -> Array:
        """See `Model.distort`."""
        k1, k2, p1, p2, k3 = d
        x, y = p[0] / p[2], p[1] / p[2]
        s = x * x + y * y
        g = 1 + s * (k1 + s * (k2 + s * k3))
        xy2 = 2 * x * y
        return np.stack([x * g + p1 * xy2 + p2 * (s + 2 * x * x), y * g + p1 * (s + 2 * y * y) + p2 * xy2])

    def distort_jacobian(self, d: Array, p: Array) -> tuple[Array, Array, Array]:
        """See `Model.distort_jacobian`."""
        k1, k2, p1, p2, k3 = d
        iz = 1 / p[2]
        x, y = p[0] * iz, p[1] * iz
        xx, yy, xy2 = x * x, y * y, 2 * x * y
        s = xx + yy
        s2 = s * s
        g = 1 + s * (k1 + s * (k2 + s * k3))
        dg = 2 * (k1 + s * (2 * k2 + 3 * k3 * s))  # dg/dx = x dg, dg/dy = y dg
        tx, ty = s + 2 * xx, s + 2 * yy

        u = np.stack([x * g + p1 * xy2 + p2 * tx, y * g + p1 * ty + p2 * xy2])

        by_d = np.empty((5, 2, *x.shape))
        by_d[0, 0], by_d[0, 1] = x * s, y * s
        by_d[1, 0], by_d[1, 1] = x * s2, y * s2
        by_d[2, 0], by_d[2, 1] = xy2, ty
        by_d[3, 0], by_d[3, 1] = tx, xy2
        np.multiply(by_d[1], s, out=by_d[4])

        ux = (g + xx * dg + 2 * p1 * y + 6 * p2 * x) * iz
        uy = (0.5 * xy2 * dg + 2 * p1 * x + 2 * p2 * y) * iz  # = vx: the field is a gradient
        vy = (g + yy * dg + 6 * p1 * y + 2 * p2 * x) * iz
        by_p = np.empty((3, 2, *x.shape))
        by_p[0, 0], by_p[0, 1] = ux, uy
        by_p[1, 0], by_p[1, 1] = uy, vy
        by_p[2, 0], by_p[2, 1] = -(x * ux + y * uy), -(x * uy + y * vy)
        return u, by_d, by_p

    def radius(self, d: Array) -> float:
        """Largest tan(angle) up to which the radial part grows: beyond it the image would fold."""
        return float(np.sqrt(first_root((3 * float(d[0]), 5 * float(d[1]), 7 * float(d[4])), MAX_RADIUS**2)))

    def valid(self, d: Array, p: Array) -> Mask:
        """See `Model.valid`."""
        inside: Mask = np.hypot(p[0], p[1]) < self.radius(d) * np.maximum(p[2], 0)
        return inside

    def undistort(self, d: Array, u: Array) -> Array:
        """Newton's method from the inverse of the radial part."""
        if not d.any():
            plain: Array = np.stack([*u, np.ones_like(u[0])]) / np.sqrt(1 + u[0] * u[0] + u[1] * u[1])
            return plain
        k1, k2, k3 = d[0], d[1], d[4]
        limit = self.radius(d)
        # Dense near the axis where the image is, and still out to the limit.
        r = np.tan(np.linspace(0, np.arctan(limit), 513))
        s = r * r
        table = r * (1 + s * (k1 + s * (k2 + s * k3)))
        # A little beyond the table's end is tried too: the tangential part moves the edge.
        length = np.hypot(u[0], u[1])
        inside = np.isfinite(length) & (length < 1.05 * table[-1])
        target = np.where(inside, u, 0.0)
        length = np.where(inside, length, 0.0)
        scale = np.interp(length, table, r) / np.where(length > 1e-12, length, 1.0)
        x, y = target * np.where(length > 1e-12, scale, 1.0)
        with np.errstate(all="ignore"):  # what runs away outside the domain is found and refused below
            for _ in range(8):
                value, _, by_p = self.distort_jacobian(d, np.stack([x, y, np.ones_like(x)]))
                e = value - target
                a, b, c = by_p[0, 0], by_p[0, 1], by_p[1, 1]
                det = a * c - b * b
                dx, dy = (c * e[0] - b * e[1]) / det, (a * e[1] - b * e[0]) / det
                x, y = x - dx, y - dy
                if np.nanmax(np.abs(dx) + np.abs(dy), initial=0.0) < 1e-14:
                    break
            value, _, by_p = self.distort_jacobian(d, np.stack([x, y, np.ones_like(x)]))
            error = np.hypot(*(value - target))
            radius = np.hypot(x, y)
            good = inside & (error < 1e-11 * (1 + length)) & (radius < limit)
            norm = np.where(good, np.sqrt(1 + radius * radius), np.nan)
            return np.stack([x / norm, y / norm, 1 / norm])
