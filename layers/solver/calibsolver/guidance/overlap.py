"""Overlap of two areas of an image."""

import numpy as np

from ..arrays import Array, Mask
from ..board import Board
from ..fitting.homography import Homographies
from ..view import View
from .target import edge_points

MASK_PX = 8


def jaccard_index(one: Array, other: Array, img_size: tuple[int, int]) -> float:
    """Area of the intersection / area of the union of two polygons (m, 2) px, inside the image."""
    first, second = rasterize(one, img_size), rasterize(other, img_size)
    union = int(np.count_nonzero(first | second))
    return float(np.count_nonzero(first & second) / union) if union else 0.0


def rasterize(polygon: Array, img_size: tuple[int, int]) -> Mask:
    """Mask (h / MASK_PX, w / MASK_PX) of the inside of a polygon (m, 2) px, by the even-odd rule."""
    w, h = img_size
    mask: Mask = np.zeros((-(-h // MASK_PX), -(-w // MASK_PX)), dtype=bool)
    if len(polygon) < 3:
        return mask
    start = np.clip((np.asarray(polygon) + 0.5) / MASK_PX - 0.5, -1e4, 1e4)
    end = np.roll(start, -1, axis=0)
    rows, columns = (np.arange(n, dtype=np.float64) for n in mask.shape)
    crossed = (start[:, 1] <= rows[:, None]) != (end[:, 1] <= rows[:, None])
    fall = np.where(start[:, 1] == end[:, 1], 1.0, end[:, 1] - start[:, 1])
    x = start[:, 0] + (rows[:, None] - start[:, 1]) / fall * (end[:, 0] - start[:, 0])
    to_the_right = crossed[:, :, None] & (x[:, :, None] > columns)
    return np.asarray(to_the_right.sum(axis=1) % 2 == 1)


def estimate_outline(board: Board, view: View) -> Array:
    """Board's edge (m, 2) px, estimated from the corners of a view by a homography."""
    q = view.image_points
    middle, scale = q.mean(axis=0), max(float(np.abs(q - q.mean(axis=0)).max()), 1e-9)
    rays = np.concatenate([(q - middle) / scale, np.ones((len(q), 1))], axis=1)
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    homography = Homographies.fit_dlt(view.object_points.T[None], rays.T[None], np.ones((1, len(q))))
    edge = (edge_points(board)[:, :2] - homography.mean[0]) / homography.spread[0]
    edge_rays = np.concatenate([edge, np.ones((len(edge), 1))], axis=1) @ homography.h[0].T
    with np.errstate(all="ignore"):
        outline: Array = edge_rays[:, :2] / edge_rays[:, 2:] * scale + middle
    return np.asarray(outline[(edge_rays[:, 2] > 0) & np.isfinite(outline).all(axis=1)])
