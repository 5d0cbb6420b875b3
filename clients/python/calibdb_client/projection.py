"""Projection of rays to pixels and back, for every distortion model of the service; numpy alone.

Pixels are OpenCV's: the centre of the top-left one is (0, 0); x right, y down, z forward. Formulas after
OpenCV's documentation ("Camera Calibration and 3D Reconstruction", "Fisheye camera model") and, for
`omnidirectional`, Mei & Rives (ICRA 2007).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import NDArray

from .errors import UsageError

Array = NDArray[np.float64]

MAX_TANGENT = 50.0
"""Tangent of the largest angle from the axis, 88.9 degrees, at which a planar model is used."""
MAX_ITERATIONS = 30
"""Newton's method settles in four or five; where it has not in these, there is no such ray."""
INVERSE_STEPS = 512
TOLERANCE = 1e-13


@dataclass(frozen=True, eq=False)
class Curve:
    """Radius in the image by the radius, or the angle, of a ray, on the domain where it grows."""

    at: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    arguments: Array
    values: Array

    @classmethod
    def growing(cls, at: Callable[[Array], Array], slope: Callable[[Array], Array], last: float) -> Curve:
        """Curve from 0 to where it first turns back, at most to `last`."""
        grid = np.minimum(last, np.tan(np.linspace(0, math.atan(last), INVERSE_STEPS + 1)))
        turns = np.flatnonzero(~(slope(grid) > 0))
        if turns.size:
            low, high = float(grid[max(turns[0] - 1, 0)]), float(grid[turns[0]])
            for _ in range(60):
                middle = (low + high) / 2
                low, high = (middle, high) if slope(np.array(middle)) > 0 else (low, middle)
            grid = np.append(grid[: turns[0]], low)
        return cls(at, slope, grid, at(grid))

    @property
    def end(self) -> float:
        """The argument at which the domain ends."""
        return float(self.arguments[-1])

    @property
    def reach(self) -> float:
        """Value of the curve at the end."""
        return float(self.values[-1])

    def inverse(self, values: Array) -> Array:
        """Arguments (n,) of `values` (n,); NaN beyond the reach."""
        place = np.clip(np.searchsorted(self.values, values, side="right"), 1, len(self.values) - 1)
        low, high = self.arguments[place - 1], self.arguments[place]
        t = np.interp(values, self.values, self.arguments)
        for _ in range(MAX_ITERATIONS):
            # Kept where the table says it is: near the turn the slope vanishes and the step runs away.
            step = np.clip(t - (self.at(t) - values) / self.slope(t), low, high) - t
            t = t + np.where(np.isfinite(step), step, 0)
            if not np.any(np.abs(step) > TOLERANCE * (1 + t)):
                break
        return np.where(values < self.reach, t, np.nan)


class BrownConrady:
    """Radial and tangential distortion of the plane z = 1 by k1 k2 p1 p2 k3 k4 k5 k6, and its inverse."""

    def __init__(self, coefficients: Sequence[float], last: float) -> None:
        self._d = [*map(float, coefficients), *([0.0] * (8 - len(coefficients)))]
        self.curve = Curve.growing(
            lambda r: r * self._radial(r * r)[0],
            lambda r: np.where(self._below(r * r) > 0, self._slope(r * r), -1.0),
            last,
        )

    def distort(self, x: Array, y: Array) -> tuple[Array, Array]:
        """Distorted coordinates; NaN beyond the domain."""
        inside = np.hypot(x, y) < self.curve.end
        a, b = self._bend(x, y)
        return np.where(inside, a, np.nan), np.where(inside, b, np.nan)

    def undistort(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Undistorted coordinates, by Newton's method from the radial inverse; NaN if there are none."""
        length = np.hypot(u, v)
        first = self.curve.inverse(length)
        # A little beyond the end is tried too: the tangential part moves the edge.
        near = np.isnan(first) & (length < 1.05 * self.curve.reach)
        scale = np.where(
            length > 0, np.where(near, self.curve.end, first) / np.where(length > 0, length, 1), 0
        )
        x, y = u * scale, v * scale
        p1, p2 = self._d[2], self._d[3]
        small = np.zeros(x.shape, dtype=bool)
        for _ in range(MAX_ITERATIONS):
            s = x * x + y * y
            radial, growth = self._radial(s)
            a, b = self._bend(x, y)
            xx = radial + 2 * x * x * growth + 2 * p1 * y + 6 * p2 * x
            xy = 2 * x * y * growth + 2 * p1 * x + 2 * p2 * y
            yy = radial + 2 * y * y * growth + 6 * p1 * y + 2 * p2 * x
            determinant = xx * yy - xy * xy
            determinant = np.where(determinant > 0, determinant, np.nan)
            dx = (yy * (a - u) - xy * (b - v)) / determinant
            dy = (xx * (b - v) - xy * (a - u)) / determinant
            x, y = x - dx, y - dy
            small = np.abs(dx) + np.abs(dy) < TOLERANCE * (1 + length)
            if np.all(small | np.isnan(x)):
                break
        good = small & (np.hypot(x, y) < self.curve.end)
        return np.where(good, x, np.nan), np.where(good, y, np.nan)

    def _below(self, s: Array) -> Array:
        k4, k5, k6 = self._d[5:]
        return 1 + s * (k4 + s * (k5 + s * k6))

    def _radial(self, s: Array) -> tuple[Array, Array]:
        """Radial factor, and its derivative with respect to the squared radius."""
        k1, k2, _, _, k3, k4, k5, k6 = self._d
        above, below = 1 + s * (k1 + s * (k2 + s * k3)), self._below(s)
        slopes = k1 + s * (2 * k2 + s * 3 * k3), k4 + s * (2 * k5 + s * 3 * k6)
        return above / below, (slopes[0] * below - above * slopes[1]) / (below * below)

    def _slope(self, s: Array) -> Array:
        radial, growth = self._radial(s)
        return radial + 2 * s * growth

    def _bend(self, x: Array, y: Array) -> tuple[Array, Array]:
        p1, p2 = self._d[2], self._d[3]
        s = x * x + y * y
        radial = self._radial(s)[0]
        return (
            x * radial + 2 * p1 * x * y + p2 * (s + 2 * x * x),
            y * radial + p1 * (s + 2 * y * y) + 2 * p2 * x * y,
        )


class Planar:
    """The models `rectilinear` and `rational`."""

    def __init__(self, d: Sequence[float]) -> None:
        self._brown = BrownConrady(d, MAX_TANGENT)

    def distort(self, p: Array) -> tuple[Array, Array]:
        """Points (n, 3) to the plane of unit focal length; NaN where the model is not one-to-one."""
        z = np.where(p[:, 2] > 0, p[:, 2], np.nan)
        return self._brown.distort(p[:, 0] / z, p[:, 1] / z)

    def undistort(self, u: Array, v: Array) -> Array:
        """Rays (n, 3) of any length."""
        x, y = self._brown.undistort(u, v)
        return np.stack([x, y, np.ones_like(x)], axis=1)


class KannalaBrandt:
    """The model `fisheye`: the image radius is a polynomial of the angle from the axis."""

    def __init__(self, d: Sequence[float]) -> None:
        k1, k2, k3, k4 = map(float, d)
        self._curve = Curve.growing(
            lambda t: t * _polynomial(t**2, (1, k1, k2, k3, k4)),
            lambda t: _polynomial(t**2, (1, 3 * k1, 5 * k2, 7 * k3, 9 * k4)),
            math.pi,
        )

    def distort(self, p: Array) -> tuple[Array, Array]:
        """Points (n, 3) to the plane of unit focal length; NaN where the model is not one-to-one."""
        r = np.hypot(p[:, 0], p[:, 1])
        angle = np.arctan2(r, p[:, 2])
        scale = np.where(r > 0, self._curve.at(angle) / np.where(r > 0, r, 1), 0)
        scale = np.where(angle <= self._curve.end, scale, np.nan)
        return p[:, 0] * scale, p[:, 1] * scale

    def undistort(self, u: Array, v: Array) -> Array:
        """Rays (n, 3) of unit length."""
        r = np.hypot(u, v)
        angle = self._curve.inverse(r)
        scale = np.where(r > 0, np.sin(angle) / np.where(r > 0, r, 1), 0)
        return np.stack([u * scale, v * scale, np.cos(angle)], axis=1)


class Unified:
    """The model `omnidirectional`: the unit sphere seen from xi behind its centre, then distorted."""

    def __init__(self, d: Sequence[float]) -> None:
        self._xi = xi = float(d[0])
        # The image radius sin t / (cos t + xi) grows up to here.
        widest = math.acos(-xi) if xi <= 1 else math.acos(-1 / xi)
        self._brown = BrownConrady(d[1:], min(self._radius(widest - 1e-6), 1e4))
        low, self._limit = 0.0, widest
        for _ in range(60):
            middle = (low + self._limit) / 2
            if self._radius(middle) < self._brown.curve.end:
                low = middle
            else:
                self._limit = middle

    def _radius(self, angle: float) -> float:
        return math.sin(angle) / (math.cos(angle) + self._xi)

    def distort(self, p: Array) -> tuple[Array, Array]:
        """Points (n, 3) to the plane of unit focal length; NaN where the model is not one-to-one."""
        angle = np.arctan2(np.hypot(p[:, 0], p[:, 1]), p[:, 2])
        depth = p[:, 2] + self._xi * np.linalg.norm(p, axis=1)
        depth = np.where((angle <= self._limit) & (depth > 0), depth, np.nan)
        return self._brown.distort(p[:, 0] / depth, p[:, 1] / depth)

    def undistort(self, u: Array, v: Array) -> Array:
        """Rays (n, 3) of unit length."""
        x, y = self._brown.undistort(u, v)
        s = x * x + y * y
        inside = 1 + (1 - self._xi**2) * s
        eta = (self._xi + np.sqrt(np.where(inside >= 0, inside, np.nan))) / (s + 1)
        return np.stack([eta * x, eta * y, eta - self._xi], axis=1)


_PLANES: dict[str, tuple[Callable[[Sequence[float]], Any], int]] = {
    "rectilinear": (Planar, 5),
    "fisheye": (KannalaBrandt, 4),
    "rational": (Planar, 8),
    "omnidirectional": (Unified, 5),
}


class Lens:
    """A camera's projection.

    Parameters
    ----------
    model
        Name of the distortion model.
    matrix
        (3, 3) camera matrix, px.
    distortion
        Coefficients in the model's order.

    Raises UsageError for a model that this version does not know.
    """

    def __init__(self, model: str, matrix: Array, distortion: Sequence[float]) -> None:
        if model not in _PLANES:
            raise UsageError(f"this version knows no distortion model {model!r}: upgrade calibdb-client")
        make, count = _PLANES[model]
        if len(distortion) != count:
            raise UsageError(f"{model} has {count} coefficients, not {len(distortion)}")
        with np.errstate(all="ignore"):
            self._plane = make([float(each) for each in distortion])
        self._f = matrix[0, 0], matrix[1, 1]
        self._c = matrix[0, 2], matrix[1, 2]

    def project(self, points: object) -> Array:
        """Pixels (n, 2) of points (n, 3), camera frame; NaN where the lens sees nothing."""
        p = _rows(points, 3)
        with np.errstate(all="ignore"):
            u, v = self._plane.distort(p)
            return np.stack([self._f[0] * u + self._c[0], self._f[1] * v + self._c[1]], axis=1)

    def unproject(self, pixels: object) -> Array:
        """Return unit rays (n, 3), camera frame, of pixels (n, 2); NaN where there are none."""
        q = _rows(pixels, 2)
        with np.errstate(all="ignore"):
            rays: Array = self._plane.undistort(
                (q[:, 0] - self._c[0]) / self._f[0], (q[:, 1] - self._c[1]) / self._f[1]
            )
            unit: Array = rays / np.linalg.norm(rays, axis=1, keepdims=True)
            return unit


def _polynomial(x: Array, coefficients: Sequence[float]) -> Array:
    """Values of the polynomial with these coefficients, the constant one first."""
    return np.asarray(polyval(x, coefficients), dtype=np.float64)


def _rows(values: object, width: int) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != width:
        raise UsageError(f"an array (n, {width}) is wanted, not {array.shape}")
    return array.reshape(-1, width)
