"""Projection by a stored calibration, in plain Python: a lookup loads no numpy."""

import functools
import itertools
import math
from collections.abc import Iterator, Sequence

from calibdb.schema import Calibration

Vector = tuple[float, float]

_AZIMUTHS, _STEPS = 16, 24
# On the plane of unit focal length, and of the valid domain: docs/conventions.md.
_MAX_RADIUS, _MIN_TANGENTIAL_RATIO = 50.0, 7.0
# Largest angle off the axis, rad, at which images are compared, by model.
_MAX_ANGLE_RAD = {"rectilinear": 1.4, "rational": 1.4, "fisheye": 1.9, "omnidirectional": 1.9}


def axis_focal(camera: Calibration) -> Vector:
    """Focal lengths along x and y, px per radian at the axis: (fx, fy) / (1 + xi)."""
    (fx, _, _), (_, fy, _), _ = camera.camera_matrix
    xi = camera.distortion_coefficients[0] if camera.distortion_model == "omnidirectional" else 0.0
    return fx / (1 + xi), fy / (1 + xi)


@functools.lru_cache(maxsize=256)
def domain_half_angle(model: str, d: tuple[float, ...]) -> float:
    """Largest angle from the axis, rad, up to which the model is one-to-one (docs/conventions.md)."""
    if model == "fisheye":
        slope = (1.0, 3 * d[0], 5 * d[1], 7 * d[2], 9 * d[3])
        return math.sqrt(_first_root(slope, math.pi**2))
    xi = d[0] if model == "omnidirectional" else 0.0
    if xi <= -1:
        return 0.0
    above, below, tangential = _planar_terms(model, d)
    by_r = [0.0] * 14
    for i, n in enumerate(above):
        for j, m in enumerate(below):
            by_r[2 * (i + j)] += n * m * (1 + 2 * i - 2 * j)
    for i, n in enumerate(below):
        for j, m in enumerate(below):
            by_r[2 * (i + j) + 1] -= _MIN_TANGENTIAL_RATIO * math.hypot(*tangential) * n * m
    r = min(_first_root(by_r, _MAX_RADIUS), math.sqrt(_first_root(below, _MAX_RADIUS**2)))
    if xi > 1:
        r = min(r, 1 / math.sqrt(xi * xi - 1))  # where the image of the unit sphere turns back
    along = (xi + math.sqrt(max(1 + (1 - xi * xi) * r * r, 0.0))) / (1 + r * r)
    return math.atan2(r * along, along - xi)


def distort_ray(model: str, d: tuple[float, ...], theta: float, phi: float) -> Vector | None:
    """Distorted point of the ray at angle `theta` off the axis, azimuth `phi`, rad; None beyond the domain.

    On the plane z = 1; its pixel is `(fx x + cx, fy y + cy)`. Formulas: docs/conventions.md.
    """
    if not theta < domain_half_angle(model, d):
        return None
    if model == "fisheye":
        # Kannala & Brandt 2006, as in cv2.fisheye
        t = theta * theta
        r = theta * (1 + t * (d[0] + t * (d[1] + t * (d[2] + t * d[3]))))
        return r * math.cos(phi), r * math.sin(phi)
    xi = d[0] if model == "omnidirectional" else 0.0
    r = math.sin(theta) / (math.cos(theta) + xi)  # Mei & Rives 2007; xi = 0: a pinhole
    a, b, r2 = r * math.cos(phi), r * math.sin(phi), r * r
    above, below, (p1, p2) = _planar_terms(model, d)
    radial = _polynomial(above, r2) / _polynomial(below, r2)
    # Brown 1966
    x = a * radial + 2 * p1 * a * b + p2 * (r2 + 2 * a * a)
    y = b * radial + p1 * (r2 + 2 * b * b) + 2 * p2 * a * b
    return x, y


def _planar_terms(model: str, d: tuple[float, ...]) -> tuple[tuple[float, ...], tuple[float, ...], Vector]:
    """Numerator and denominator of the radial factor, by r^2; the tangential coefficients."""
    if model == "omnidirectional":
        return (1.0, d[1], d[2]), (1.0,), (d[3], d[4])
    return (1.0, d[0], d[1], d[4]), (1.0, *d[5:]), (d[2], d[3])


def _polynomial(coefficients: Sequence[float], x: float) -> float:
    """Value at x; the constant coefficient comes first."""
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * x + coefficient
    return value


def _first_root(coefficients: Sequence[float], limit: float) -> float:
    """Smallest root in (0, limit) of a polynomial, or `limit` if there is none."""
    return next(iter(_roots(coefficients, limit)), limit)


def _roots(coefficients: Sequence[float], limit: float) -> list[float]:
    """Roots in (0, limit) at which a polynomial changes its sign."""
    degree = max((i for i, c in enumerate(coefficients) if c != 0), default=0)
    if degree < 1:
        return []
    turns = _roots([i * c for i, c in enumerate(coefficients[: degree + 1])][1:], limit)
    roots = []
    for low, high in itertools.pairwise([0.0, *turns, limit]):
        is_positive = _polynomial(coefficients, low) > 0
        if (_polynomial(coefficients, high) > 0) == is_positive:
            continue
        while low < (middle := (low + high) / 2) < high:
            if (_polynomial(coefficients, middle) > 0) == is_positive:
                low = middle
            else:
                high = middle
        roots.append(low)
    return roots


def rays_in_view(camera: Calibration) -> Iterator[tuple[float, float, Vector]]:
    """Yield rays that the camera sees and their pixel, `(theta, phi, (u, v))`, outwards along 16 azimuths."""
    (fx, _, cx), (_, fy, cy), _ = camera.camera_matrix
    w, h = camera.img_size
    model, d = camera.distortion_model, camera.distortion_coefficients
    # A narrow lens also has 12 steps from the centre.
    step = min(_MAX_ANGLE_RAD[model] / _STEPS, max(w / fx, h / fy) / _STEPS)
    for i in range(_AZIMUTHS):
        phi = (i + 0.5) * 2 * math.pi / _AZIMUTHS
        theta = 0.0
        while (theta := theta + step) < _MAX_ANGLE_RAD[model]:
            at = distort_ray(model, d, theta, phi)
            if at is None:
                break
            u, v = fx * at[0] + cx, fy * at[1] + cy
            if not (-0.5 <= u <= w - 0.5 and -0.5 <= v <= h - 0.5):
                break
            yield theta, phi, (u, v)
