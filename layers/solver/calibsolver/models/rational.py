"""OpenCV's 8-coefficient model, for lenses that bend more than a polynomial can: k1 k2 p1 p2 k3 k4 k5 k6.

x = X/Z, y = Y/Z, s = x^2 + y^2, g = (1 + k1 s + k2 s^2 + k3 s^3) / (1 + k4 s + k5 s^2 + k6 s^3), and the
tangential part of `planar` (OpenCV documentation, CALIB_RATIONAL_MODEL; after Claus & Fitzgibbon 2005).
"""

import math

import numpy as np

from ..arrays import Array
from .base import Coefficient, Prior, first_root
from .planar import MAX_RADIUS, MIN_TANGENTIAL_RATIO, Pinhole

ANGLE = (7 / 9, 64 / 945, 10 / 9, 5 / 21)
"""k1 k2 k4 k5 of Pade's approximant of atan(r) / r, to 0.3 % up to 63 degrees."""

ORDERS = np.arange(1.0, 4.0)
TWICE, STRETCHED = 2 * ORDERS, 1 + 2 * ORDERS


class Rational(Pinhole):
    """OpenCV's 8-coefficient model."""

    name = "rational"
    coefficients = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
    start_families = 2
    radial_at = (0, 1, 4, 5, 6, 7)
    tangential_at = (2, 3)
    prior = Prior(
        focal=0.7,
        focal_sigma=0.5,
        # Numerator and denominator may both be large where their quotient is not: only that is seen.
        distortion=(
            Coefficient(2.0, 1, 1.0),
            Coefficient(4.0, 2, 1.0),
            Coefficient(0.006),
            Coefficient(0.006),
            Coefficient(5.0, 3, 1.0),
            Coefficient(2.0, 1, 1.0, sign=-1),
            Coefficient(4.0, 2, 1.0, sign=-1),
            Coefficient(5.0, 3, 1.0, sign=-1),
        ),
    )
    start_focals = (0.2, 0.28, 0.38, 0.52, 0.72, 1.0, 1.4, 1.9, 2.8)

    def initial_intrinsics(self, img_size: tuple[int, int]) -> list[Array]:
        """Lenses whose image radius is the angle from the axis, and pinholes."""
        pinholes = super().initial_intrinsics(img_size)
        angular = [k.copy() for k in pinholes]
        for k in angular:
            k[[4, 5, 9, 10]] = ANGLE
        return angular + pinholes

    def radial(self, d: Array, s: Array) -> Array:
        g: Array = (1 + s * (d[0] + s * (d[1] + s * d[4]))) / (1 + s * (d[5] + s * (d[6] + s * d[7])))
        return g

    def radial_jacobian(self, d: Array, s: Array) -> tuple[Array, Array, tuple[Array, ...]]:
        inverse = 1 / (1 + s * (d[5] + s * (d[6] + s * d[7])))
        g = (1 + s * (d[0] + s * (d[1] + s * d[4]))) * inverse
        a1 = s * inverse
        a2 = a1 * s
        a3 = a2 * s
        slope = d[0] + s * (2 * d[1] + 3 * d[4] * s) - g * (d[5] + s * (2 * d[6] + 3 * d[7] * s))
        return g, slope * inverse, (a1, a2, a3, -g * a1, -g * a2, -g * a3)

    def radial_derivative(self, d: Array, s: Array) -> tuple[Array, Array, Array]:
        """Exact: no first order serves where numerator and denominator, each large, cancel."""
        above, below = np.array([d[0], d[1], d[4]]), d[5:]
        column = s[:, None]
        powers = column**ORDERS
        lower = powers * ORDERS / column
        n, m = 1 + powers @ above, 1 + powers @ below
        n_s, m_s = lower @ above, lower @ below
        # h = a / m - b n / m^2
        a, b = n + 2 * s * n_s, 2 * s * m_s
        a_s, b_s = lower @ (above * STRETCHED), lower @ (below * TWICE)
        by_d = np.zeros((len(s), len(d)))
        by_above = powers * (STRETCHED - (b / m)[:, None]) / m[:, None]
        by_d[:, :2], by_d[:, 4] = by_above[:, :2], by_above[:, 2]
        mm = m * m
        by_m = (2 * b * n / m - a) / mm
        by_d[:, 5:] = powers * (by_m[:, None] - TWICE * (n / mm)[:, None])
        by_s = a_s / m - (n_s * b + n * b_s) / mm + by_m * m_s
        return a / m - b * n / mm, by_d, by_s

    def domain_radius(self, d: Array) -> float:
        """Radius up to which the radial part grows and has no pole."""
        k1, k2, p1, p2, k3, k4, k5, k6 = (float(c) for c in d)
        above, below, power = np.array([1, k1, k2, k3]), np.array([1, k4, k5, k6]), np.arange(4)
        # d(r g)/dr times the squared denominator, a polynomial in s
        grows = np.convolve(above * (1 + 2 * power), below) - 2 * np.convolve(above, below * power)
        in_r = np.zeros(14)
        in_r[::2] = grows
        in_r[1::2] -= MIN_TANGENTIAL_RATIO * math.hypot(p1, p2) * np.convolve(below, below)
        pole = first_root((0.0, k4, 0.0, k5, 0.0, k6), MAX_RADIUS)
        return min(first_root(tuple(in_r[1:].tolist()), MAX_RADIUS), pole)
