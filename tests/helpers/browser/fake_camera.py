"""A Chromium whose camera shows a board."""

from contextlib import AbstractContextManager
from pathlib import Path

import cv2
import numpy as np
from playwright.sync_api import Page, Playwright

from . import stop_and_go

WIDTH, HEIGHT = 1280, 720
SQUARE = 80  # texture pixels


def board_seen() -> tuple[np.ndarray, np.ndarray]:
    """Grey picture of the default board as OpenCV draws it, tilted, and its corners (40, 2)."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard((9, 6), 1, 0.65, dictionary)
    texture = board.generateImage((11 * SQUARE, 8 * SQUARE), marginSize=SQUARE)
    matrix = np.array([[1000, 0, 640], [0, 1000, 360], [0, 0, 1.0]])
    rotation, translation = np.array([0.25, -0.45, 0.05]), np.array([-4.0, -2.8, 10.0])
    plane = matrix @ np.column_stack([cv2.Rodrigues(rotation)[0][:, :2], translation])
    # Texture pixel → board: the origin is the edge of the first square, half a pixel before its centre.
    to_board = np.array([[1 / SQUARE, 0, 0.5 / SQUARE - 1], [0, 1 / SQUARE, 0.5 / SQUARE - 1], [0, 0, 1]])
    picture = cv2.warpPerspective(texture, plane @ to_board, (WIDTH, HEIGHT), borderValue=120)
    corners = np.array([(x, y, 0.0) for y in range(1, 6) for x in range(1, 9)])
    points = cv2.projectPoints(corners, rotation, translation, matrix, None)[0].reshape(-1, 2)
    return cv2.GaussianBlur(picture, (0, 0), 0.7), points


def camera(playwright: Playwright, url: str, folder: Path, rate: int = 20) -> AbstractContextManager[Page]:
    """Give a page in a Chromium whose camera shows a board."""
    picture = cv2.cvtColor(board_seen()[0], cv2.COLOR_GRAY2BGR)
    return stop_and_go.camera(playwright, url, stop_and_go.write(folder / "board.y4m", [picture] * 4, rate))
