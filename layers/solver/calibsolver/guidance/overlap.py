"""How far two areas of an image are the same."""

import cv2
import numpy as np
import numpy.typing as npt

from ..arrays import Array
from ..board import Board
from ..view import View
from .target import edge_points

SCALE = 8
"""Pixels of the image a pixel of the masks."""


def jaccard(one: Array, other: Array, img_size: tuple[int, int]) -> float:
    """Area of the intersection / area of the union of two polygons (m, 2) px, inside the image."""
    first, second = mask(one, img_size), mask(other, img_size)
    union = int(np.count_nonzero(first | second))
    return float(np.count_nonzero(first & second) / union) if union else 0.0


def mask(polygon: Array, img_size: tuple[int, int]) -> npt.NDArray[np.uint8]:
    """Inside of a polygon (m, 2) px, as (h / SCALE, w / SCALE) of 0 and 1."""
    w, h = img_size
    picture = np.zeros((-(-h // SCALE), -(-w // SCALE)), dtype=np.uint8)
    if len(polygon) >= 3:
        corners = np.clip(polygon / SCALE, -1e4, 1e4)
        cv2.fillPoly(picture, [np.round(corners * 16).astype(np.int32)], 1, shift=4)
    return picture


def seen_outline(board: Board, view: View) -> Array:
    """Where the board's edge (m, 2) px lies by the corners seen, as far as a homography tells."""
    p, q = view.object_points[:, :2], view.image_points
    h, _ = cv2.findHomography(p, q, 0)
    if h is None:
        return np.empty((0, 2))
    flat = edge_points(board)[:, :2]
    edge: Array = np.concatenate([flat, np.ones((len(flat), 1))], axis=1) @ np.asarray(h, dtype=np.float64).T
    with np.errstate(all="ignore"):
        outline: Array = edge[:, :2] / edge[:, 2:]
    return outline[(edge[:, 2] > 0) & np.isfinite(outline).all(axis=1)]
