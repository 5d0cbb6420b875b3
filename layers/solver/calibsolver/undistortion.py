"""Rectified pictures of one camera: camera matrices and remap tables, for every distortion model."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .arrays import Array
from .camera import Camera
from .errors import CalibrationError

MAX_RECTIFIED_ANGLE_DEG = 80.0
"""Largest angle from the axis in a rectified picture: beyond, the plane grows without bound."""
BORDER_POINTS = 65
HALVINGS = 40


def new_camera_matrix(camera: Camera, alpha: float = 0.0, size: Sequence[int] | None = None) -> Array:
    """Camera matrix (3, 3) of a rectified picture of a size, px, as cv2.getOptimalNewCameraMatrix scales it.

    With `alpha` 0 every pixel of the rectified picture has a colour, with 1 every pixel of the picture is
    kept. If the model has no ray for the picture's border, the edge of its domain replaces it. Raises
    CalibrationError ``out_of_range`` if alpha lies outside 0 to 1.
    """
    if not 0 <= alpha <= 1:
        raise CalibrationError("out_of_range", f"alpha lies in 0 to 1, not {alpha}")
    (w, h), (new_w, new_h) = camera.img_size, size or camera.img_size
    x, y = np.linspace(0, w - 1, BORDER_POINTS), np.linspace(0, h - 1, BORDER_POINTS)
    edges = ((x, 0.0), (x, h - 1.0), (0.0, y), (w - 1.0, y))
    borders = [np.stack(np.broadcast_arrays(*edge), axis=1) for edge in edges]
    top, bottom, left, right = (_on_plane(_rays_near(camera, border)) for border in borders)
    everything = np.concatenate([top, bottom, left, right])
    if not np.isfinite(everything).any():
        return np.array(camera.matrix)
    outer = (*everything.min(axis=0), *everything.max(axis=0))
    inner = (left[:, 0].max(), top[:, 1].max(), right[:, 0].min(), bottom[:, 1].min())
    if not (inner[0] < inner[2] and inner[1] < inner[3]):
        inner = outer
    matrices = [_fill(bounds, (int(new_w), int(new_h))) for bounds in (inner, outer)]
    return (1 - alpha) * matrices[0] + alpha * matrices[1]


def remap_tables(
    camera: Camera, matrix: object = None, size: Sequence[int] | None = None
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Columns and rows (h, w) px from which the pixels of a rectified picture come.

    Pixels that the lens does not see come from -1, outside the picture. The (3, 3) matrix of the rectified
    picture and its size, px, are the camera's unless given. Raises CalibrationError ``bad_camera`` for an
    invalid matrix.
    """
    new = np.asarray(camera.matrix if matrix is None else matrix, dtype=np.float64)
    if new.shape != (3, 3) or not abs(np.linalg.det(new)) > 0:
        raise CalibrationError(
            "bad_camera", "the camera matrix of the rectified picture must be (3, 3) and invertible"
        )
    w, h = (int(side) for side in size or camera.img_size)
    u, v = np.meshgrid(np.arange(w, dtype=np.float64), np.arange(h, dtype=np.float64))
    pixels = np.stack([u.ravel(), v.ravel(), np.ones(w * h)], axis=1)
    source = camera.project(pixels @ np.linalg.inv(new).T)
    source = np.where(np.isfinite(source), source, -1.0).astype(np.float32)
    return np.ascontiguousarray(source[:, 0].reshape(h, w)), np.ascontiguousarray(source[:, 1].reshape(h, w))


def _rays_near(camera: Camera, border: Array) -> Array:
    """Rays (n, 3) of pixels (n, 2) of the border, or of the last pixels with a ray on the way there."""
    rays = camera.unproject(border)
    if np.isfinite(rays).all():
        return rays
    inside = np.tile(_middle(camera), (len(border), 1))
    outside = border
    for _ in range(HALVINGS):
        half = (inside + outside) / 2
        has_ray = np.isfinite(camera.unproject(half)).all(axis=1, keepdims=True)
        inside, outside = np.where(has_ray, half, inside), np.where(has_ray, outside, half)
    return np.where(np.isfinite(rays), rays, camera.unproject(inside))


def _middle(camera: Camera) -> Array:
    """Pixel (2,) with a ray that is closest to the middle of the picture; NaN if no pixel has one."""
    w, h = camera.img_size
    x, y = np.meshgrid(np.linspace(0, w - 1, BORDER_POINTS), np.linspace(0, h - 1, BORDER_POINTS))
    pixels = np.stack([x.ravel(), y.ravel()], axis=1)
    has_ray = np.isfinite(camera.unproject(pixels)).all(axis=1)
    distance = np.where(has_ray, np.linalg.norm(pixels - np.array([w - 1, h - 1]) / 2, axis=1), np.inf)
    return pixels[np.argmin(distance)] if has_ray.any() else np.full(2, np.nan)


def _on_plane(rays: Array) -> Array:
    """Rays (n, 3) on the plane z = 1, pulled to `MAX_RECTIFIED_ANGLE_DEG`."""
    limit = math.radians(MAX_RECTIFIED_ANGLE_DEG)
    r = np.hypot(rays[:, 0], rays[:, 1])
    angle = np.minimum(np.arctan2(r, rays[:, 2]), limit)
    scale = np.tan(angle) / np.where(r > 0, r, 1)
    return rays[:, :2] * scale[:, None]


def _fill(bounds: Sequence[float], size: tuple[int, int]) -> Array:
    left, top, right, bottom = bounds
    fx, fy = (size[0] - 1) / (right - left), (size[1] - 1) / (bottom - top)
    return np.array([[fx, 0, -fx * left], [0, fy, -fy * top], [0, 0, 1.0]])
