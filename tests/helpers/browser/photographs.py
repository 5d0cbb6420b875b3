"""Drawn photographs of a board by a known camera."""

from __future__ import annotations

import functools
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
import numpy.typing as npt

from calibsolver import Board
from calibsolver.guidance.overlay import draw_board

from .truth import Truth

if TYPE_CHECKING:  # of the browser tests only
    from playwright.sync_api import Request

Grey = npt.NDArray[np.uint8]

#: board of the photographs, also of those in CALIBDB_DATA
SQUARES, MARKER_RATIO, DICTIONARY = 8, 0.75, "DICT_4X4_1000"
BOARD = Board((SQUARES, SQUARES), MARKER_RATIO, DICTIONARY)
CAMERA = Truth(fx=680.0, cx=326.0, cy=236.0, k1=-0.12, size=(640, 480))
MAKE, MODEL = "Drawn", "Test Camera"
BLUR, NOISE, JPEG_QUALITY = 0.8, 2.0, 92  # px, grey levels, of 100
SQUARE = 64  # texture pixels
SAMPLES = 2  # along each side of a pixel


def textured_board(size: tuple[int, int]) -> Grey:
    """Draw a turned board that fills a picture, under texture of 4 to 64 px."""
    width, height = size
    side = width + height // 4
    square = side // 24
    texture = draw_board(Board((24, 24), MARKER_RATIO, DICTIONARY), square)
    turn = cv2.getRotationMatrix2D((12 * square, 12 * square), 8.0, side / (24 * square))
    turn[:, 2] += np.array([width / 2, height / 2]) - 12 * square
    drawn = 128 + 0.68 * (cv2.warpAffine(texture, turn, size, flags=cv2.INTER_LINEAR).astype(float) - 128)
    rng = np.random.default_rng(0)
    for period, amplitude in ((4, 8), (16, 8), (64, 12)):  # px, grey levels
        noise = rng.normal(0, amplitude, (height // period + 2, width // period + 2))
        drawn += cv2.resize(noise, size, interpolation=cv2.INTER_CUBIC)
    return np.asarray(np.clip(drawn, 0, 255), dtype=np.uint8)


@functools.cache
def _rays() -> npt.NDArray[np.float64]:
    """Directions x, y, 1 at SAMPLES x SAMPLES places in each of the camera's pixels, row by row."""
    offsets = (np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5
    u, v = ((np.arange(side)[:, None] + offsets).ravel() for side in CAMERA.size)
    q = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 1, 2)
    exact = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_COUNT, 10, 1e-7)
    xy = cv2.undistortPoints(q, CAMERA.matrix, CAMERA.distortion, criteria=exact).reshape(-1, 2)
    return np.column_stack([xy, np.ones(len(xy))])


def _photograph(
    texture: Grey,
    origin: npt.NDArray[np.float64],
    rotation: npt.NDArray[np.float64],
    translation: npt.NDArray[np.float64],
    seed: int,
) -> Grey:
    """Draw a board, whose texture has a margin of a square, as the camera sees it, blurred and with noise."""
    w, h = CAMERA.size
    board = _rays() @ np.linalg.inv(np.column_stack([rotation[:, :2], translation])).T
    # Texture pixels: the origin of the board is the edge of its first square.
    place = SQUARE * (board[:, :2] / board[:, 2:] - origin) + SQUARE - 0.5
    maps = np.float32(place).reshape(SAMPLES * h, SAMPLES * w, 2)
    fine = cv2.remap(texture, maps, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=90)
    grey = fine.astype(float).reshape(h, SAMPLES, w, SAMPLES).mean(axis=(1, 3))
    blurred = cv2.GaussianBlur(30 + 0.75 * grey, (0, 0), BLUR)
    noise = np.random.default_rng(seed).normal(0, NOISE, blurred.shape)
    return np.asarray(np.clip(blurred + noise, 0, 255).round(), dtype=np.uint8)


def board_photographs(board: Board, count: int) -> Iterator[Grey]:
    """Draw photographs of any board by the camera, whole in the picture, tilted by 20 to 40 degrees."""
    rng = np.random.default_rng(3)
    texture = draw_board(board, SQUARE)
    edge = 0 if board.inverted else 255
    texture = cv2.copyMakeBorder(texture, SQUARE, SQUARE, SQUARE, SQUARE, cv2.BORDER_CONSTANT, value=edge)
    origin = board.outline[0, :2]
    middle = np.append(origin + np.array(board.size) / 2, 0)
    w, h = CAMERA.size
    for index in range(count):
        # To another side each time, and turned a little.
        azimuth = 2.4 * index
        tilt = np.radians(rng.uniform(20, 40)) * np.array([np.cos(azimuth), np.sin(azimuth), 0])
        turn = np.array([0, 0, rng.uniform(-0.3, 0.3)])
        rotation = cv2.Rodrigues(tilt)[0] @ cv2.Rodrigues(turn)[0]
        depth = rng.uniform(1.35, 1.8) * CAMERA.fx * max(board.size[0] / w, board.size[1] / h)
        place = depth * np.array([0.1 * np.cos(1.1 * index), 0.07 * np.sin(1.1 * index), 1])
        yield _photograph(texture, origin, rotation, place - rotation @ middle, index)


def jpeg(picture: Grey, orientation: int = 1) -> bytes:
    """Encode a picture as JPEG whose EXIF data names the camera."""
    words = (MAKE.encode() + b"\0", MODEL.encode() + b"\0")
    at = 8 + 2 + 3 * 12 + 4  # after the directory
    entries = (
        struct.pack("<HHII", 0x010F, 2, len(words[0]), at)
        + struct.pack("<HHII", 0x0110, 2, len(words[1]), at + len(words[0]))
        + struct.pack("<HHIHH", 0x0112, 3, 1, orientation, 0)
    )
    header = struct.pack("<2sHI", b"II", 42, 8)
    block = header + struct.pack("<H", 3) + entries + struct.pack("<I", 0) + b"".join(words)
    body = b"Exif\0\0" + block
    data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()
    return data[:2] + b"\xff\xe1" + struct.pack(">H", len(body) + 2) + body + data[2:]


def draw(folder: Path, count: int = 12) -> list[Path]:
    """Write up to twelve photographs; the EXIF data of every third says that the camera was turned."""
    paths = []
    for index, picture in enumerate(board_photographs(BOARD, count)):
        path = folder / f"drawn-{index:02}.jpg"
        path.write_bytes(jpeg(picture, 6 if index % 3 == 2 else 1))
        paths.append(path)
    return paths


def draw_other(folder: Path) -> Path:
    """Write a photograph of another size."""
    (picture,) = board_photographs(BOARD, 1)
    path = folder / "larger.jpg"
    path.write_bytes(jpeg(np.asarray(cv2.resize(picture, None, fx=2, fy=2), dtype=np.uint8)))
    return path


def sent_views(sent: list[Request]) -> list[dict[str, Any]]:
    """Views that a page posted, each once."""
    posted = [r.post_data or "" for r in sent if r.url.endswith("/session/batch") and r.method == "POST"]
    views = [view for each in posted for view in json.loads(each)["views"]]
    return list({json.dumps(view["points"]): view for view in views}.values())


def opencv_fit(
    board: Board, views: list[dict[str, Any]], size: tuple[int, int]
) -> tuple[float, npt.NDArray[np.float64], float]:
    """RMS, camera matrix and standard deviation of fx, px, that OpenCV finds with views of a board."""
    objects = [board.points[view["ids"]].astype(np.float32) for view in views]
    points = [np.array(view["points"], dtype=np.float32)[:, None] for view in views]
    extended = cv2.calibrateCameraExtended(objects, points, size, None, None)
    return float(extended[0]), extended[1], float(extended[5][0][0])
