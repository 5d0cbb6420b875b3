"""The picture of a target pose: the board through the full camera model."""

import math
from functools import lru_cache
from typing import Literal

import cv2
import numpy as np
import numpy.typing as npt

from . import rotation
from .arrays import Array
from .board import Board
from .camera import Camera
from .target import TargetPose

STRIDE = 8
"""Pixels between the rays that are computed; between them board coordinates are interpolated."""
SQUARE = 32
"""Texture pixels a square, at least."""
QUALITY = 50

Picture = npt.NDArray[np.uint8]


def render(
    board: Board, camera: Camera, target: TargetPose, image_format: Literal["jpeg", "png"] = "jpeg"
) -> bytes:
    """Picture of `camera.img_size` with the board at the target pose, black elsewhere.

    White squares are green and black ones magenta: two hues of similar brightness, made for the CSS blend
    mode `color`, and no pixel of the board is black. PNG has an alpha channel that is 0 outside the board.
    Where the model is not one-to-one nothing is drawn.

    Raises ValueError for an unknown format.
    """
    if image_format not in ("jpeg", "png"):
        raise ValueError(f"unknown image format {image_format!r}")
    w, h = camera.img_size
    canvas = np.zeros((h, w, 2), dtype=np.uint8)
    box = bounds(target.outline, camera.img_size)
    if box is not None:
        x0, y0, x1, y1 = box
        coordinates = board_coordinates(camera, target, box, resolution(board))
        patch = cv2.remap(
            texture(board),
            coordinates,
            np.empty(0, dtype=np.float32),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=(0, 0),
        )
        canvas[y0:y1, x0:x1] = patch
    magenta, green = cv2.split(canvas)
    if image_format == "jpeg":
        picture = cv2.merge([magenta, green, magenta])
        ok, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    else:
        picture = cv2.merge([magenta, green, magenta, cv2.add(magenta, green)])
        ok, data = cv2.imencode(".png", picture, [cv2.IMWRITE_PNG_COMPRESSION, 3])
    if not ok:  # cannot happen with memory left
        raise MemoryError("the overlay could not be encoded")
    return data.tobytes()


def bounds(outline: Array, img_size: tuple[int, int]) -> tuple[int, int, int, int] | None:
    """Part of the image (x0, y0, x1, y1) that holds an outline (m, 2) and a little more; None outside it."""
    w, h = img_size
    if not len(outline):
        return None
    margin = 4
    low, high = outline.min(axis=0), outline.max(axis=0)
    x0, y0 = (int(np.clip(np.floor(v) - margin, 0, s)) for v, s in zip(low, (w, h), strict=True))
    x1, y1 = (int(np.clip(np.ceil(v) + margin + 1, 0, s)) for v, s in zip(high, (w, h), strict=True))
    return (x0, y0, x1, y1) if x1 > x0 and y1 > y0 else None


def resolution(board: Board) -> int:
    """Texture pixels a square: enough for one a cell of the smallest marker."""
    return max(SQUARE, math.ceil((board.marker_size + 2) / board.marker_ratio))


def board_coordinates(
    camera: Camera, target: TargetPose, box: tuple[int, int, int, int], square: int
) -> npt.NDArray[np.float32]:
    """Texture coordinates (y1 - y0, x1 - x0, 2) of a box of pixels; far outside where there are none."""
    x0, y0, x1, y1 = box
    columns, rows = -(-(x1 - x0) // STRIDE) + 1, -(-(y1 - y0) // STRIDE) + 1
    x, y = np.meshgrid(x0 + STRIDE * np.arange(columns), y0 + STRIDE * np.arange(rows))
    ray = camera.unproject(np.stack([x, y], axis=-1).reshape(-1, 2).astype(np.float64))
    r = rotation.matrix(target.rvec)
    # The ray s v meets the plane z = 0 of the board at R'(s v - t).
    v, t = ray @ r, r.T @ target.tvec
    with np.errstate(divide="ignore", invalid="ignore"):
        s = t[2] / v[:, 2]
        xy = np.where((s > 0)[:, None], s[:, None] * v[:, :2] - t[:2], np.nan)
    coarse = (xy * square - 0.5).reshape(rows, columns, 2).astype(np.float32)
    step = np.array([[1 / STRIDE, 0, 0], [0, 1 / STRIDE, 0]])
    fine = cv2.warpAffine(
        np.clip(coarse, -1e5, 1e5),
        step,
        (x1 - x0, y1 - y0),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    if not np.isfinite(coarse).all():
        fine[~np.isfinite(fine)] = -1e5
    return np.asarray(fine, dtype=np.float32)


@lru_cache(maxsize=16)
def texture(board: Board) -> Picture:
    """Draw the board, `resolution` px a square, channels (black, white) squares, (rows, columns, 2)."""
    gray = image(board, resolution(board))
    return np.ascontiguousarray(np.stack([255 - gray, gray], axis=-1))


def image(board: Board, square: int) -> Picture:
    """Black and white picture of the whole board without margin, `square` px a square."""
    w, h = board.size
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    charuco = cv2.aruco.CharucoBoard((w, h), 1.0, board.marker_ratio, dictionary)
    charuco.setLegacyPattern(board.legacy)
    return np.asarray(
        charuco.generateImage((w * square, h * square), marginSize=0, borderBits=1), dtype=np.uint8
    )
