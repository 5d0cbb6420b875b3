"""Overlap of two areas of an image: the Jaccard index."""

import cv2
import numpy as np
import numpy.typing as npt

from ..arrays import Array
from ..board import Board
from ..view import View
from .target import edge_points

MASK_PX = 8
"""Side of a mask's pixel, px of the image."""


def jaccard_index(one: Array, other: Array, img_size: tuple[int, int]) -> float:
    """Area of the intersection / area of the union of two polygons (m, 2) px, inside the image."""
    first, second = rasterize(one, img_size), rasterize(other, img_size)
    union = int(np.count_nonzero(first | second))
    return float(np.count_nonzero(first & second) / union) if union else 0.0


def rasterize(polygon: Array, img_size: tuple[int, int]) -> npt.NDArray[np.uint8]:
    """Rasterize the inside of a polygon (m, 2) px: a mask (h / MASK_PX, w / MASK_PX) of 0 and 1."""
    w, h = img_size
    picture = np.zeros((-(-h // MASK_PX), -(-w // MASK_PX)), dtype=np.uint8)
    if len(polygon) >= 3:
        corners = np.clip(polygon / MASK_PX, -1e4, 1e4)
        cv2.fillPoly(picture, [np.round(corners * 16).astype(np.int32)], 1, shift=4)
    return picture


def estimate_outline(board: Board, view: View) -> Array:
    """Estimate the board's edge (m, 2) px from the corners of a view, by a homography."""
    p, q = view.object_points[:, :2], view.image_points
    h, _ = cv2.findHomography(p, q, 0)
    if h is None:
        return np.empty((0, 2))
    flat = edge_points(board)[:, :2]
    edge: Array = np.concatenate([flat, np.ones((len(flat), 1))], axis=1) @ np.asarray(h, dtype=np.float64).T
    with np.errstate(all="ignore"):
        outline: Array = edge[:, :2] / edge[:, 2:]
    return outline[(edge[:, 2] > 0) & np.isfinite(outline).all(axis=1)]
