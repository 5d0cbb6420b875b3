"""OpenCV's 5-coefficient model of lenses that keep straight lines nearly straight: k1 k2 p1 p2 k3.

x = X/Z, y = Y/Z, s = x^2 + y^2, g = 1 + k1 s + k2 s^2 + k3 s^3, and the tangential part of `planar`
(OpenCV documentation, "Camera Calibration and 3D Reconstruction"; after Brown 1971).
"""

import math

import numpy as np

from ..arrays import Array
from .base import Coefficient, Prior, first_root
from .planar import MAX_RADIUS, MIN_TANGENTIAL_RATIO, Pinhole


def _linear_forms() -> Array:
    """Matrix (48, 6) from (1, k1, k2, p1, p2, k3) to the coefficients of 1, x, y, s, s^2, s^3 in eight forms.

    a = g + 2 (p2 x + p1 y); 2 dg/ds; p2 s and p1 s; then a + 4 p2 x, 2 (p1 x + p2 y) twice, and a + 4 p1 y.
    """
    out = np.zeros((8, 6, 6))
    for form in (0, 4, 7):
        out[form, 0, 0] = out[form, 3, 1] = out[form, 4, 2] = out[form, 5, 5] = 1
        out[form, 1, 4] = out[form, 2, 3] = 2
    out[4, 1, 4] = out[7, 2, 3] = 6
    out[1, 0, 1], out[1, 3, 2], out[1, 4, 5] = 2, 4, 6
    out[2, 3, 4] = out[3, 3, 3] = 1
    for form in (5, 6):
        out[form, 1, 3] = out[form, 2, 4] = 2
    return out.reshape(48, 6)


LINEAR_FORMS = _linear_forms()


class Rectilinear(Pinhole):
    """OpenCV's 5-coefficient model."""

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

    def fill_jacobian(self, k: Array, p: Array, by_k: Array, by_p: Array) -> Array:
        """In the parts linear in 1, x, y, s, s^2 and s^3, one matrix product."""
        shape = p.shape[1:]
        column = (2,) + (1,) * len(shape)
        f, c = k[:2].reshape(column), k[2:4].reshape(column)
        iz = 1 / p[2]
        terms = np.empty((6, *shape))
        terms[0] = 1
        xy, s = terms[1:3], terms[3]
        np.multiply(p[:2], iz, out=xy)
        products = xy[:, None] * xy  # x^2, xy, xy, y^2
        np.add(products[0, 0], products[1, 1], out=s)
        np.multiply(s, s, out=terms[4])
        np.multiply(terms[4], s, out=terms[5])
        d = k[3:].copy()
        d[0] = 1
        forms = ((LINEAR_FORMS @ d).reshape(8, 6) @ terms.reshape(6, -1)).reshape(8, *shape)
        along, slope, u, by_xy = forms[0], forms[1], forms[2:4], forms[4:].reshape(2, 2, *shape)
        u += xy * along
        by_xy += products * slope
        by_k[:4] = 0
        by_k[0, 0], by_k[1, 1] = u
        by_k[2, 0] = by_k[3, 1] = 1
        scaled = xy * f
        np.multiply(scaled, terms[3:5, None], out=by_k[4:6])
        np.multiply(scaled, terms[5], out=by_k[8])
        products *= 2
        products[0, 0] += s
        products[1, 1] += s
        np.multiply(products, f, out=by_k[7:5:-1])
        np.multiply(f, iz, out=scaled)
        np.multiply(by_xy, scaled, out=by_p[:2])
        along_ray = by_p[:2] * xy[:, None]
        np.add(along_ray[0], along_ray[1], out=by_p[2])
        np.negative(by_p[2], out=by_p[2])
        u *= f
        u += c
        return u

    def radial(self, d: Array, s: Array) -> Array:
        g: Array = 1 + s * (d[0] + s * (d[1] + s * d[4]))
        return g

    def radial_jacobian(self, d: Array, s: Array) -> tuple[Array, Array, tuple[Array, ...]]:
        s2 = s * s
        return self.radial(d, s), d[0] + s * (2 * d[1] + 3 * d[4] * s), (s, s2, s2 * s)

    def domain_radius(self, d: Array) -> float:
        """Radius up to which the radial part grows."""
        k1, k2, p1, p2, k3 = (float(c) for c in d)
        return first_root(
            (-MIN_TANGENTIAL_RATIO * math.hypot(p1, p2), 3 * k1, 0.0, 5 * k2, 0.0, 7 * k3), MAX_RADIUS
        )
