"""Where in the image a lens bends most, of what has not been looked at yet."""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from ..arrays import Array
from ..camera import Camera

CELL = 20
"""px of the grid on which the distortion is looked at."""
LEAST_WIDTH = 0.3
"""Of the image, that a region is made wide at least."""
COVERED = 0.9
"""Share of a region that was shown from which another is sought."""


@dataclass(frozen=True)
class Box:
    """A part of the image: left, top, width and height as shares of its width and height."""

    left: float
    top: float
    width: float
    height: float


def next_region(camera: Camera, shown: Sequence[Box]) -> Box:
    """Return the most distorted part of the image that is not yet covered by what was `shown`.

    The threshold on the map of |distorted - undistorted| falls from 95 % of its largest value in steps of
    5 % until a connected region appears that is covered by less than COVERED.
    """
    w, h = camera.img_size
    columns, rows = max(w // CELL, 2), max(h // CELL, 2)
    strength = displacement(camera, columns, rows)
    seen = np.zeros((rows, columns), dtype=bool)
    x, y = (np.arange(columns) + 0.5) / columns, (np.arange(rows) + 0.5) / rows
    for box in shown:
        across = (x >= box.left) & (x <= box.left + box.width)
        down = (y >= box.top) & (y <= box.top + box.height)
        seen |= down[:, None] & across[None]
    largest = strength.max()
    for percent in range(95, 0, -5):
        mask = (strength >= percent / 100 * largest).astype(np.uint8)
        count, labels = cv2.connectedComponents(mask, connectivity=8)
        for label in range(1, count):
            region = labels == label
            if seen[region].mean() < COVERED:
                return around(region)
    return Box(0.0, 0.0, 1.0, 1.0)


def displacement(camera: Camera, columns: int, rows: int) -> Array:
    """How far the lens moves a point, px, on a grid (rows, columns); what has no ray moves farthest."""
    w, h = camera.img_size
    x, y = (np.arange(columns) + 0.5) * w / columns - 0.5, (np.arange(rows) + 0.5) * h / rows - 0.5
    q = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    ray = camera.unproject(q)
    (fx, _, cx), (_, fy, cy), _ = camera.matrix
    with np.errstate(all="ignore"):
        straight = ray[:, :2] / ray[:, 2:] * (fx, fy) + (cx, cy)
        moved = np.linalg.norm(straight - q, axis=1)
    moved = np.where(ray[:, 2] > 0.05, moved, np.nan)
    farthest = np.nanmax(moved) if np.isfinite(moved).any() else 1.0
    field: Array = np.nan_to_num(moved, nan=farthest).reshape(rows, columns)
    return field


def around(region: Array) -> Box:
    """Return the bounding box of a region (rows, columns), made LEAST_WIDTH of the image at least."""
    rows, columns = region.shape
    y, x = np.nonzero(region)
    left, right = x.min() / columns, (x.max() + 1) / columns
    top, bottom = y.min() / rows, (y.max() + 1) / rows
    width, height = max(right - left, LEAST_WIDTH), max(bottom - top, LEAST_WIDTH)
    left = float(np.clip((left + right - width) / 2, 0, 1 - width))
    top = float(np.clip((top + bottom - height) / 2, 0, 1 - height))
    return Box(left, top, float(width), float(height))
