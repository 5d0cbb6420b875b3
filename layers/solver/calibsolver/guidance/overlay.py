"""Overlay: picture of a target pose, drawn through the full camera model."""

import math
from functools import lru_cache
from typing import Literal

import cv2
import numpy as np
import numpy.typing as npt

from ..arrays import Array
from ..board import Board
from ..camera import Camera
from .target import TargetPose

STRIDES_PX = (16, 8)
"""Spacing of the rays that are computed; interpolated ones are right to a few hundredths of a pixel. The
smaller one is used at the end of the model's domain."""
OFF_BOARD = 1e4
"""Texture coordinate of pixels without a board: within the range of fixed-point maps."""
MARGIN_PX = 4
MIN_TEXTURE_PX_PER_SQUARE = 32
TAG_BORDER = 2
"""Width of the black frame of an AprilGrid's tag, cells, as Kalibr prints it; of other markers it is one."""
JPEG_QUALITIES = (45, 30, 15)
MAX_PICTURE_PX = 12_000_000
"""A larger picture is drawn smaller, in the same shape, and its reader scales it up."""
MAX_JPEG_BYTES = 60_000
"""Size from which a JPEG is coded again at the next lower quality."""

Picture = npt.NDArray[np.uint8]

GRAY_LEVELS = np.arange(256, dtype=np.uint8)
COLOR_MAP: Picture = np.where(
    GRAY_LEVELS[:, None] > 0, np.stack([255 - GRAY_LEVELS, GRAY_LEVELS, 255 - GRAY_LEVELS], axis=1), 0
).astype(np.uint8)[:, None]
"""Blue, green, red (256, 1, 3) of a gray level: black without a board, then from magenta to green."""


def render(
    board: Board, camera: Camera, target: TargetPose, image_format: Literal["jpeg", "png"] = "jpeg"
) -> bytes:
    """Picture of `drawn_size(camera.img_size)` with the board at the target pose, black elsewhere.

    White squares are green and black ones magenta, hues of similar brightness for the CSS blend mode
    `color`; no pixel of the board is black. The alpha channel of a PNG is 0 outside the board. Nothing is
    drawn where the model is not one-to-one. Raises ValueError for an unknown format.
    """
    if image_format not in ("jpeg", "png"):
        raise ValueError(f"unknown image format {image_format!r}")
    w, h = drawn = drawn_size(camera.img_size)
    scale = np.array(camera.img_size) / drawn
    canvas = np.zeros((h, w), dtype=np.uint8)
    box = bounding_box(target.outline, scale, drawn)
    if box is not None:
        x0, y0, x1, y1 = box
        # Fixed-point maps are read twice as fast, to a 32nd of a pixel of the texture.
        place, part = cv2.convertMaps(
            texture_coordinates(camera, target, box, texture_px_per_square(board), scale, board.outline[0]),
            np.empty(0),
            cv2.CV_16SC2,
        )
        canvas[y0:y1, x0:x1] = cv2.remap(
            texture(board), place, part, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0
        )
    picture: Picture = np.asarray(cv2.applyColorMap(canvas, COLOR_MAP), dtype=np.uint8)
    if image_format == "png":
        alpha = cv2.threshold(canvas, 0, 255, cv2.THRESH_BINARY)[1]
        with_alpha = np.asarray(cv2.merge([*cv2.split(picture), alpha]), dtype=np.uint8)
        return cv2.imencode(".png", with_alpha, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()
    for quality in JPEG_QUALITIES:
        data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
        if len(data) <= MAX_JPEG_BYTES:
            break
    return data


def drawn_size(img_size: tuple[int, int]) -> tuple[int, int]:
    """Width and height, px, at which the picture for an image of `img_size` is drawn."""
    w, h = img_size
    shrink = math.sqrt(min(1.0, MAX_PICTURE_PX / (w * h)))
    return max(1, math.floor(w * shrink)), max(1, math.floor(h * shrink))


def bounding_box(outline: Array, scale: Array, size: tuple[int, int]) -> tuple[int, int, int, int] | None:
    """Bounding box (x0, y0, x1, y1) of an image's outline (m, 2), with a margin, in the picture; or None."""
    if not len(outline):
        return None
    px = (outline + 0.5) / scale - 0.5
    low = np.clip(np.floor(px.min(axis=0)) - MARGIN_PX, 0, size).astype(int)
    high = np.clip(np.ceil(px.max(axis=0)) + MARGIN_PX + 1, 0, size).astype(int)
    (x0, y0), (x1, y1) = low.tolist(), high.tolist()
    return (x0, y0, x1, y1) if x1 > x0 and y1 > y0 else None


def texture_px_per_square(board: Board) -> int:
    """Texture pixels per square, or side of a tag: at least one per cell of a marker."""
    if board.kind == "chessboard":
        return MIN_TEXTURE_PX_PER_SQUARE
    ratio, border = (board.marker_ratio, 1) if board.kind == "charuco" else (1.0, TAG_BORDER)
    return max(MIN_TEXTURE_PX_PER_SQUARE, math.ceil((board.marker_size + 2 * border) / ratio))


def texture_coordinates(
    camera: Camera,
    target: TargetPose,
    box: tuple[int, int, int, int],
    square: int,
    scale: Array,
    corner: Array,
) -> npt.NDArray[np.float32]:
    """Texture coordinates (y1 - y0, x1 - x0, 2) of a box of pixels; outside the texture if there are none.

    The picture is `scale` (2,) times smaller than the image; the texture begins at `corner` of the board.
    """
    for stride in STRIDES_PX:
        coarse = (board_coordinates(camera, target, box, stride, scale) - corner[:2]) * square - 0.5
        if np.isfinite(coarse).all():
            break
    x0, y0, x1, y1 = box
    step = np.array([[1 / stride, 0, 0], [0, 1 / stride, 0]])
    fine = cv2.warpAffine(
        np.clip(coarse, -OFF_BOARD, OFF_BOARD).astype(np.float32),
        step,
        (x1 - x0, y1 - y0),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
    if not np.isfinite(coarse).all():
        fine[~np.isfinite(fine)] = -OFF_BOARD
    return np.asarray(fine, dtype=np.float32)


def board_coordinates(
    camera: Camera, target: TargetPose, box: tuple[int, int, int, int], stride: int, scale: Array
) -> Array:
    """Board coordinates (rows, columns, 2), squares, of every `stride`-th pixel; NaN where there are none."""
    x0, y0, x1, y1 = box
    columns, rows = -(-(x1 - x0) // stride) + 1, -(-(y1 - y0) // stride) + 1
    x, y = np.meshgrid(x0 + stride * np.arange(columns), y0 + stride * np.arange(rows))
    pixels = np.stack([x, y], axis=-1).reshape(-1, 2).astype(np.float64)
    ray = camera.unproject((pixels + 0.5) * scale - 0.5)
    # The ray s v meets the plane z = 0 of the board at R'(s v - t).
    v, t = ray @ target.r, target.r.T @ target.tvec
    with np.errstate(divide="ignore", invalid="ignore"):
        s = t[2] / v[:, 2]
        xy: Array = np.where((s > 0)[:, None], s[:, None] * v[:, :2] - t[:2], np.nan)
    return xy.reshape(rows, columns, 2)


@lru_cache(maxsize=16)
def texture(board: Board) -> Picture:
    """Picture of the board (rows, columns) to sample from: 1 black, 255 white; 0 means no board."""
    return np.maximum(draw_board(board, texture_px_per_square(board)), 1)


def draw_board(board: Board, square: int) -> Picture:
    """Picture of the whole board, black and white, without margin; `square`: px per square or tag."""
    draw = {"charuco": _draw_charuco, "chessboard": _draw_chessboard, "aprilgrid": _draw_aprilgrid}[
        board.kind
    ]
    picture = draw(board, square)
    return np.asarray(255 - picture, dtype=np.uint8) if board.inverted else picture


def _draw_charuco(board: Board, square: int) -> Picture:
    w, h = board.squares
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    charuco = cv2.aruco.CharucoBoard((w, h), 1.0, board.marker_ratio, dictionary)
    charuco.setLegacyPattern(board.legacy)
    return np.asarray(
        charuco.generateImage((w * square, h * square), marginSize=0, borderBits=1), dtype=np.uint8
    )


def _draw_chessboard(board: Board, square: int) -> Picture:
    w, h = board.squares
    white = np.indices((h, w)).sum(axis=0) % 2
    return np.kron(white * 255, np.ones((square, square))).astype(np.uint8)


def _draw_aprilgrid(board: Board, square: int) -> Picture:
    """Tags, and a black square in every gap where four of them meet, as Kalibr prints them."""
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, board.dictionary))
    w, h = (math.ceil(side * square) for side in board.size)
    gap = round(board.tag_spacing * square)
    picture = np.full((h, w), 255, dtype=np.uint8)
    columns, rows = board.squares
    for row in range(rows):
        for column in range(columns):
            x = round(column * (1 + board.tag_spacing) * square)
            y = round((rows - 1 - row) * (1 + board.tag_spacing) * square)
            tag = cv2.aruco.generateImageMarker(
                dictionary, row * columns + column, square, borderBits=TAG_BORDER
            )
            picture[y : y + square, x : x + square] = tag[: h - y, : w - x]
            if row and column + 1 < columns:
                picture[y + square : y + square + gap, x + square : x + square + gap] = 0
    return picture
