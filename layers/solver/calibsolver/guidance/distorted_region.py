"""Most distorted region of the image that no target has covered yet."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Array, Mask
from ..camera import Camera, pixel_grid

CELL_PX = 20
"""Spacing of the grid on which the distortion is evaluated."""
MIN_REGION_SHARE = 0.3
"""Width and height of a region / those of the image."""
MIN_COVERED_SHARE = 0.9
"""Share of a region that earlier targets have covered, from which another region is sought."""


@dataclass(frozen=True)
class Box:
    """Rectangle of the image: left, top, width and height as shares of its width and height."""

    left: float
    top: float
    width: float
    height: float


def find_next_region(camera: Camera, covered: Sequence[Box]) -> Box:
    """Find the most distorted part of the image that is not yet `covered`; else the whole image.

    The threshold on the map of |distorted - undistorted| falls from 95 % of its largest value in steps of
    5 % until a connected region appears that is covered by less than MIN_COVERED_SHARE.
    """
    w, h = camera.img_size
    columns, rows = max(w // CELL_PX, 2), max(h // CELL_PX, 2)
    strength = displacement(camera, columns, rows)
    covered_cells = np.zeros((rows, columns), dtype=bool)
    x, y = (np.arange(columns) + 0.5) / columns, (np.arange(rows) + 0.5) / rows
    for box in covered:
        across = (x >= box.left) & (x <= box.left + box.width)
        down = (y >= box.top) & (y <= box.top + box.height)
        covered_cells |= down[:, None] & across[None]
    largest = strength.max()
    for percent in range(95, 0, -5):
        for region in connected_regions(strength >= percent / 100 * largest):
            if covered_cells[region].mean() < MIN_COVERED_SHARE:
                return bounding_box(region)
    return Box(0.0, 0.0, 1.0, 1.0)


def connected_regions(mask: Mask) -> Iterator[Mask]:
    """Yield the connected regions (8 neighbours) of a mask (rows, columns), from its top left."""
    left = {(int(y), int(x)) for y, x in np.argwhere(mask)}
    for first in sorted(left):
        region = np.zeros_like(mask)
        reached = [first] if first in left else []
        left -= {first}
        while reached:
            y, x = reached.pop()
            region[y, x] = True
            near = {(y + dy, x + dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1)} & left
            left -= near
            reached += near
        if region.any():
            yield region


def displacement(camera: Camera, columns: int, rows: int) -> Array:
    """Displacement of pixels by the distortion, px, on a grid (rows, columns).

    Against a pinhole camera of the same focal length, px per radian at the axis. Pixels without a ray, or
    whose ray is nearly perpendicular to the axis, get the largest displacement of all others.
    """
    q = pixel_grid(camera.img_size, (columns, rows)).reshape(2, -1).T
    ray = camera.unproject(q)
    center = camera.intrinsics[2:4]
    with np.errstate(all="ignore"):
        pinhole = ray[:, :2] / ray[:, 2:] * camera.focal + center
        distance = np.linalg.norm(pinhole - q, axis=1)
    distance = np.where(ray[:, 2] > 0.05, distance, np.nan)
    largest = np.nanmax(distance) if np.isfinite(distance).any() else 1.0
    field: Array = np.nan_to_num(distance, nan=largest).reshape(rows, columns)
    return field


def bounding_box(region: Mask) -> Box:
    """Bounding box of a region (rows, columns), enlarged to MIN_REGION_SHARE of the image."""
    rows, columns = region.shape
    y, x = np.nonzero(region)
    left, right = x.min() / columns, (x.max() + 1) / columns
    top, bottom = y.min() / rows, (y.max() + 1) / rows
    width, height = max(right - left, MIN_REGION_SHARE), max(bottom - top, MIN_REGION_SHARE)
    left = float(np.clip((left + right - width) / 2, 0, 1 - width))
    top = float(np.clip((top + bottom - height) / 2, 0, 1 - height))
    return Box(left, top, float(width), float(height))
