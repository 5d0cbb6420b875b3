"""Kannala-Brandt's model as in cv2.fisheye: k1 k2 k3 k4.

t = angle between ray and axis, a = t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8), (u, v) = a (X, Y) / |(X, Y)|
(Kannala & Brandt 2006; OpenCV documentation, "Fisheye camera model"). By atan2 the angle is also that of
points next to and behind the camera: OpenCV's x/z form ends at 90 degrees.
"""

import numpy as np

from ..arrays import Array
from .base import Coefficient, Model, Prior, first_root

TINY = 1e-200


def image_radius(d: Array, t: Array) -> Array:
    """Image radius a (...) at angles t (...)."""
    s = t * t
    a: Array = t * (1 + s * (d[0] + s * (d[1] + s * (d[2] + s * d[3]))))
    return a


def radial_slope(d: Array, s: Array) -> Array:
    """Derivative (...) of the image radius by the angle, at squared angles s (...)."""
    da: Array = 1 + s * (3 * d[0] + s * (5 * d[1] + s * (7 * d[2] + s * 9 * d[3])))
    return da


class Fisheye(Model):
    """Kannala-Brandt's model as in cv2.fisheye."""

    name = "fisheye"
    coefficients = ("k1", "k2", "k3", "k4")
    prior = Prior(
        focal=0.6,
        focal_sigma=0.6,
        distortion=(
            Coefficient(0.5, 1, 0.4),
            Coefficient(2.0, 2, 0.3),
            Coefficient(5.0, 3, 0.4),
            Coefficient(10.0, 4, 0.4),
        ),
    )
    start_focals = (0.2, 0.28, 0.38, 0.52, 0.72, 1.0, 1.4, 1.9, 2.5)

    def distort(self, d: Array, p: Array) -> Array:
        r = np.hypot(p[0], p[1])
        # On the axis a/r is 1/z; with r = 0 the product below is 0 whatever the quotient.
        m = image_radius(d, np.arctan2(r, p[2])) / np.maximum(r, TINY)
        return np.stack([p[0] * m, p[1] * m])

    def distort_jacobian(self, d: Array, p: Array) -> tuple[Array, Array, Array]:
        x, y, z = p
        rr = x * x + y * y
        r = np.sqrt(rr)
        t = np.arctan2(r, z)
        s = t * t
        a, da = image_radius(d, t), radial_slope(d, s)
        ir = 1 / np.maximum(r, 1e-150)
        cx, cy = x * ir, y * ir  # direction in the image
        on_axis = r < 1e-9 * np.abs(z)
        m = np.where(on_axis, 1 / np.where(z == 0, 1.0, z), a * ir)
        u = np.stack([x * m, y * m])

        by_d = np.empty((4, 2, *x.shape))
        by_d[0] = np.stack([cx, cy]) * (t * s)
        for i in range(1, 4):
            np.multiply(by_d[i - 1], s, out=by_d[i])

        irr = da / (rr + z * z)
        n = np.where(on_axis, 0.0, z * irr - m)  # r dm/dr
        by_p = np.empty((3, 2, *x.shape))
        by_p[0, 0], by_p[1, 1] = m + cx * cx * n, m + cy * cy * n
        by_p[0, 1] = by_p[1, 0] = cx * cy * n
        by_p[2, 0], by_p[2, 1] = -x * irr, -y * irr
        return u, by_d, by_p

    def domain_half_angle(self, d: Array) -> float:
        return float(np.sqrt(first_root(tuple((d * (3, 5, 7, 9)).tolist()), np.pi**2)))

    def undistort(self, d: Array, u: Array) -> Array:
        """Newton's method on the angle only, from a table."""
        if not d.any():
            t = np.hypot(u[0], u[1])
            t = np.where(t < np.pi, t, np.nan)
            m = np.sinc(t / np.pi)
            return np.stack([u[0] * m, u[1] * m, np.cos(t)])
        limit = self.domain_half_angle(d)
        grid = np.linspace(0, limit, 513)
        table = image_radius(d, grid)
        r = np.hypot(u[0], u[1])
        good = np.isfinite(r) & (r < table[-1])
        radius = np.where(good, r, 0.0)
        t = np.interp(radius, table, grid)
        with np.errstate(all="ignore"):  # the derivative vanishes at the edge itself: refused below
            for _ in range(8):
                step = (image_radius(d, t) - radius) / radial_slope(d, t * t)
                t = t - step
                if np.nanmax(np.abs(step), initial=0.0) < 1e-14:
                    break
            good &= (np.abs(image_radius(d, t) - radius) < 1e-12 * (1 + radius)) & (t >= 0) & (t < limit)
        t = np.where(good, t, np.nan)
        m = np.sin(t) / np.where(radius > 1e-12, radius, 1.0)
        return np.stack([u[0] * m, u[1] * m, np.cos(t)])
