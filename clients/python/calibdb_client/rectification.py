"""Rectified pictures: camera matrices and remap tables, for every distortion model; numpy alone."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .errors import UsageError
from .projection import Array, Lens

if TYPE_CHECKING:
    from numpy.typing import NDArray

MAX_RECTIFIED_ANGLE_DEG = 80.0
"""Largest angle from the axis that a rectified picture shows: beyond, the plane grows without bound."""
_BORDER_POINTS = 65


def new_camera_matrix(
    lens: Lens, img_size: tuple[int, int], alpha: float = 0.0, size: Sequence[int] | None = None
) -> Array:
    """Return the camera matrix (3, 3) of a rectified picture, as cv2.getOptimalNewCameraMatrix scales it.

    Parameters
    ----------
    lens, img_size
        The camera, and the width and height of its picture, px.
    alpha
        0: every pixel of the rectified picture has a colour; 1: every pixel of the picture is kept.
    size
        Width and height of the rectified picture, px; `img_size` unless given.

    Raises UsageError if alpha lies outside 0 to 1, or if the lens sees nothing in front of it.
    """
    if not 0 <= alpha <= 1:
        raise UsageError(f"alpha lies in 0 to 1, not {alpha}")
    (w, h), (new_w, new_h) = img_size, size or img_size
    x, y = np.linspace(0, w - 1, _BORDER_POINTS), np.linspace(0, h - 1, _BORDER_POINTS)
    edges = {
        "top": np.stack([x, np.zeros_like(x)], axis=1),
        "bottom": np.stack([x, np.full_like(x, h - 1)], axis=1),
        "left": np.stack([np.zeros_like(y), y], axis=1),
        "right": np.stack([np.full_like(y, w - 1), y], axis=1),
    }
    planes = {name: _on_plane(lens.unproject(edge)) for name, edge in edges.items()}
    everything = np.concatenate(list(planes.values()))
    outer = (*np.nanmin(everything, axis=0), *np.nanmax(everything, axis=0))
    inner = (
        np.nanmax(planes["left"][:, 0]),
        np.nanmax(planes["top"][:, 1]),
        np.nanmin(planes["right"][:, 0]),
        np.nanmin(planes["bottom"][:, 1]),
    )
    if not (inner[0] < inner[2] and inner[1] < inner[3]):
        inner = outer
    matrices = [_fill(bounds, (int(new_w), int(new_h))) for bounds in (inner, outer)]
    return (1 - alpha) * matrices[0] + alpha * matrices[1]


def remap_tables(
    lens: Lens, matrix: Array, size: tuple[int, int]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the columns and the rows (h, w) px from which the pixels of a rectified picture come.

    Pixels that the lens does not see come from -1, outside the picture.

    Raises UsageError for a matrix that is none.
    """
    if matrix.shape != (3, 3) or not abs(np.linalg.det(matrix)) > 0:
        raise UsageError("the camera matrix of the rectified picture must be (3, 3) and invertible")
    w, h = size
    u, v = np.meshgrid(np.arange(w, dtype=np.float64), np.arange(h, dtype=np.float64))
    pixels = np.stack([u.ravel(), v.ravel(), np.ones(w * h)], axis=1)
    seen = lens.project(pixels @ np.linalg.inv(matrix).T)
    seen = np.where(np.isfinite(seen), seen, -1.0).astype(np.float32)
    return np.ascontiguousarray(seen[:, 0].reshape(h, w)), np.ascontiguousarray(seen[:, 1].reshape(h, w))


def _on_plane(rays: Array) -> Array:
    """Rays (n, 3) on the plane z = 1, pulled to `MAX_RECTIFIED_ANGLE_DEG`; UsageError for none."""
    limit = math.radians(MAX_RECTIFIED_ANGLE_DEG)
    r = np.hypot(rays[:, 0], rays[:, 1])
    angle = np.minimum(np.arctan2(r, rays[:, 2]), limit)
    scale = np.tan(angle) / np.where(r > 0, r, 1)
    plane: Array = rays[:, :2] * scale[:, None]
    if not np.isfinite(plane).any():
        raise UsageError("no ray of the picture's border can be rectified: crop the picture")
    return plane


def _fill(bounds: Sequence[float], size: tuple[int, int]) -> Array:
    left, top, right, bottom = bounds
    fx, fy = (size[0] - 1) / (right - left), (size[1] - 1) / (bottom - top)
    return np.array([[fx, 0, -fx * left], [0, fy, -fy * top], [0, 0, 1.0]])
