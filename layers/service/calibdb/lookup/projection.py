"""Projection by a stored calibration, in plain Python: a lookup loads no numpy.

Enough to compare two calibrations over an image, some hundred rays; fits and overlays are the solver's.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from calibdb.schema import Calibration

Vector = tuple[float, float]

_AZIMUTHS, _STEPS = 16, 24
# Largest angle off the axis, rad, by the models that this module can project by.
_MAX_ANGLE_RAD = {"rectilinear": 1.4, "rational": 1.4, "fisheye": 1.9, "omnidirectional": 1.9}


def is_projectable(camera: Calibration) -> bool:
    """Tell whether this module knows the formulas of the camera's model."""
    return camera.distortion_model in _MAX_ANGLE_RAD


def axis_focal(camera: Calibration) -> Vector:
    """Return the focal lengths along x and y, px per radian at the axis; raises ValueError.

    The fx of an omnidirectional camera is (1 + xi) times that.
    """
    if not is_projectable(camera):
        raise ValueError(f"no formulas for {camera.distortion_model}")
    (fx, _, _), (_, fy, _), _ = camera.camera_matrix
    xi = camera.distortion_coefficients[0] if camera.distortion_model == "omnidirectional" else 0.0
    return fx / (1 + xi), fy / (1 + xi)


def distort_ray(model: str, d: tuple[float, ...], theta: float, phi: float) -> Vector:
    """Intersection of the ray at angle `theta` off the axis, azimuth `phi` (rad), with the plane z = 1.

    Distortion included: a pixel is `(fx x + cx, fy y + cy)`. Formulas: docs/conventions.md.
    """
    if model == "fisheye":
        # Kannala & Brandt 2006, as in cv2.fisheye
        t = theta * theta
        r = theta * (1 + t * (d[0] + t * (d[1] + t * (d[2] + t * d[3]))))
        return r * math.cos(phi), r * math.sin(phi)
    xi = d[0] if model == "omnidirectional" else 0.0
    r = math.sin(theta) / (math.cos(theta) + xi)  # Mei & Rives 2007; xi = 0: a pinhole
    a, b, r2 = r * math.cos(phi), r * math.sin(phi), r * r
    k1, k2, p1, p2 = d[1:5] if model == "omnidirectional" else d[:4]
    k3 = 0.0 if model == "omnidirectional" else d[4]
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    if model == "rational":
        radial /= 1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7]))
    # Brown 1966
    x = a * radial + 2 * p1 * a * b + p2 * (r2 + 2 * a * a)
    y = b * radial + p1 * (r2 + 2 * b * b) + 2 * p2 * a * b
    return x, y


def rays_in_view(camera: Calibration) -> Iterator[tuple[float, float, Vector]]:
    """Yield rays that the camera sees, with their pixel: `(theta, phi, (u, v))`, outwards along 16 azimuths.

    Only as far as the picture reaches, and no further than the model is one-to-one.
    """
    (fx, _, cx), (_, fy, cy), _ = camera.camera_matrix
    w, h = camera.img_size
    model, d = camera.distortion_model, camera.distortion_coefficients
    # No step is longer than a twelfth of the picture, however narrow the lens.
    step = min(_MAX_ANGLE_RAD[model] / _STEPS, max(w / fx, h / fy) / _STEPS)
    for i in range(_AZIMUTHS):
        phi = (i + 0.5) * 2 * math.pi / _AZIMUTHS
        theta, farthest = 0.0, 0.0
        while (theta := theta + step) < _MAX_ANGLE_RAD[model]:
            if model == "omnidirectional" and math.cos(theta) + d[0] <= 0:
                break
            x, y = distort_ray(model, d, theta, phi)
            u, v = fx * x + cx, fy * y + cy
            radius = x * x + y * y
            if not (radius > farthest and -0.5 <= u <= w - 0.5 and -0.5 <= v <= h - 0.5):
                break
            farthest = radius
            yield theta, phi, (u, v)
