"""Cameras of models that calibsolver does not fit: the rays of their pixels, and the closest own camera.

Sources: Usenko, Demmel & Cremers, "The double sphere camera model", 3DV 2018 (double sphere, and the extended
unified model of Khomutenko, Garcia & Martinet, RA-L 2016); Scaramuzza, Martinelli & Siegwart, IROS 2006, and
the OCamCalib toolbox; Lensfun's manual, "Lens distortion models".
"""

from collections.abc import Callable

import numpy as np

from .. import models
from ..arrays import Array
from ..camera import Camera
from ..errors import CalibrationError
from . import text
from .base import ImportedFile, ModelConstraint
from .members import Members, normalise
from .ray_fit import fit_samples, sample_pixels

Unprojection = Callable[[Array], Array]
"""Rays (n, 3) of pixels (n, 2), of any length; NaN where there are none."""
MAX_APPROXIMATION_WIDTHS = 0.01
"""Image widths by which the closest camera may be off somewhere."""
EQUAL_PX = 0.05
"""Error below which the simpler of two models is taken."""


def closest_camera(rays_of: Unprojection, size: tuple[int, int], name: str = "") -> ImportedFile:
    """Return the closest camera of calibsolver's models, with its largest error over the picture.

    Raises CalibrationError ``malformed`` if none comes near.
    """
    q = sample_pixels(size).T
    with np.errstate(all="ignore"):
        rays = rays_of(q)
        rays = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    there = np.isfinite(rays).all(axis=1)
    if there.mean() < 0.2:
        raise text.refuse("the camera in the file has rays for too little of its picture")
    results: list[tuple[float, Camera]] = []
    for model in ("fisheye", "omnidirectional", "rectilinear", "rational"):
        within = there & (rays[:, 2] > np.cos(models.get(model).max_angle))
        if within.sum() < there.sum():
            continue
        try:
            camera = fit_samples(rays[within].T, q[within].T, size, ModelConstraint(model))
        except CalibrationError:
            continue
        off = np.linalg.norm(camera.project(rays[there]) - q[there], axis=1)
        if np.isfinite(off).all():
            results.append((float(off.max()), camera))
    if not results:
        raise text.refuse("no model of calibsolver comes near the camera in the file")
    least = min(error for error, _ in results)
    error, camera = next(each for each in results if each[0] <= max(EQUAL_PX, least))
    if error > MAX_APPROXIMATION_WIDTHS * size[0]:
        raise text.refuse(f"the closest model is {error:.1f} px off somewhere in the picture of the file")
    return ImportedFile(camera, name=name, error=error)


def named_rays(members: Members, matrix: Array) -> Unprojection | None:
    """Return the rays of a camera whose members name the double sphere or the extended unified model."""
    kind = normalise(members.get("cameratype", "cameramodel", "distortionmodel", "type", "model") or "")
    names = {
        **dict.fromkeys(("ds", "doublesphere"), ("xi", "alpha")),
        **dict.fromkeys(("eucm", "extendedunified"), ("alpha", "beta")),
    }
    if kind not in names or not all(name in members for name in names[kind]):
        return None
    one, other = (text.scalar(members.get(name), name) for name in names[kind])
    return rays_of_kind(kind, matrix, one, other)


def rays_of_kind(kind: str, matrix: Array, one: float, other: float) -> Unprojection:
    """Return the rays of a double sphere camera (xi, alpha) or an extended unified one (alpha, beta)."""
    rays = _double_sphere if kind.startswith("d") else _extended_unified

    def rays_of(q: Array) -> Array:
        x, y = (q - matrix[:2, 2]).T / np.diagonal(matrix)[:2, None]
        return rays(x, y, one, other)

    return rays_of


def _double_sphere(x: Array, y: Array, xi: float, alpha: float) -> Array:
    r2 = x * x + y * y
    mz = (1 - alpha**2 * r2) / (alpha * np.sqrt(1 - (2 * alpha - 1) * r2) + 1 - alpha)
    scale = (mz * xi + np.sqrt(mz**2 + (1 - xi**2) * r2)) / (mz**2 + r2)
    return np.stack([scale * x, scale * y, scale * mz - xi], axis=1)


def _extended_unified(x: Array, y: Array, alpha: float, beta: float) -> Array:
    r2 = x * x + y * y
    z = (1 - beta * alpha**2 * r2) / (alpha * np.sqrt(1 - (2 * alpha - 1) * beta * r2) + 1 - alpha)
    return np.stack([x, y, z], axis=1)


def _scaramuzza(
    polynomial: Array, centre: tuple[float, float], affine: tuple[float, float, float]
) -> Unprojection:
    """Return the rays of a camera of the OCamCalib toolbox: centre row and column, affine c, d, e."""
    c, d, e = affine
    inverse = np.linalg.inv(np.array([[c, d], [e, 1.0]]))

    def rays_of(q: Array) -> Array:
        rows_columns = (q[:, ::-1] - centre) @ inverse.T
        z = np.polynomial.polynomial.polyval(np.linalg.norm(rows_columns, axis=1), polynomial)
        return np.stack([rows_columns[:, 1], rows_columns[:, 0], -z], axis=1)

    return rays_of


def is_ocamcalib(content: str) -> bool:
    """True if a text is a calib_results.txt of the OCamCalib toolbox."""
    return "#polynomial coefficients for the DIRECT mapping" in content


def read_ocamcalib(content: str) -> ImportedFile:
    """Read a calib_results.txt, a polynomial of the distance from the centre: the closest camera.

    Pixels are counted from 0, rows before columns, and the optical axis is -z. Raises as `closest_camera`
    does.
    """
    rows = [
        numbers
        for line in content.splitlines()[:200]
        if line.strip() and not line.lstrip().startswith("#")
        if (numbers := text.number_list(line)) is not None
    ]
    if len(rows) < 5 or len(rows[2]) != 2 or len(rows[3]) != 3 or len(rows[4]) != 2:
        raise text.refuse("the file has not the five rows of calib_results.txt")
    count = int(rows[0][0])
    polynomial = text.floats(rows[0][1:], "polynomial", 1, 30)
    if len(polynomial) != count or not polynomial[0]:
        raise text.refuse("the polynomial has not as many coefficients as the file says")
    height, width = (text.count(value, "image size") for value in rows[4])
    centre, affine = (rows[2][0], rows[2][1]), (rows[3][0], rows[3][1], rows[3][2])
    if abs(affine[0] - affine[1] * affine[2]) < 1e-6:
        raise text.refuse("the affine parameters are singular")
    if polynomial[0] > 0:  # written by programs that look along +z
        polynomial = -polynomial
    return closest_camera(_scaramuzza(np.array(polynomial), centre, affine), (width, height))


def radial_corrected(
    distort: Callable[[Array], Array], unit: float, focal: float, centre: tuple[float, float]
) -> Unprojection:
    """Return the rays of a camera whose distorted radius is a function of the corrected one.

    Radii and `focal` are in units of `unit` px.
    """
    corrected = np.linspace(0, 4, 8001)
    table = distort(corrected)
    turn = np.flatnonzero(np.diff(table) <= 0)
    end = int(turn[0]) + 1 if len(turn) else len(table)

    def rays_of(q: Array) -> Array:
        off = (q - centre) / unit
        radius = np.hypot(off[:, 0], off[:, 1])
        ideal = np.interp(radius, table[:end], corrected[:end], right=np.nan)
        scale = ideal / np.where(radius > 0, radius, 1)
        return np.stack([off[:, 0] * scale, off[:, 1] * scale, np.full(len(q), focal)], axis=1)

    return rays_of
