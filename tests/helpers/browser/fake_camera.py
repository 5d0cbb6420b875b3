"""A Chromium whose camera shows a board."""

from contextlib import AbstractContextManager
from pathlib import Path

import cv2
import numpy as np
from playwright.sync_api import Page, Playwright

from calibdb_client import Board
from calibdb_client.board_sheet import png

from . import stop_and_go

SIZE = (1280, 720)
SQUARE = 80  # texture pixels
MATRIX = np.array([[1000, 0, 640], [0, 1000, 360], [0, 0, 1.0]])
TILT = np.array([0.25, -0.45, 0.05])


def board_seen(board: Board) -> tuple[np.ndarray, np.ndarray]:
    """Grey picture of a tilted board, and its corners (n, 2)."""
    sheet = cv2.imdecode(np.frombuffer(png(board, SQUARE), np.uint8), cv2.IMREAD_GRAYSCALE)
    rotation = cv2.Rodrigues(TILT)[0]
    middle = np.array([*board.edge.mean(axis=0), 0])
    translation = np.array([0, 0, 1.2 * max(board.size)]) - rotation @ middle
    # Pixels of the sheet to squares: a margin of half a square, pixel centres at whole numbers.
    left, top = board.edge[0] + 0.5 / SQUARE - 0.5
    to_board = np.array([[1 / SQUARE, 0, left], [0, 1 / SQUARE, top], [0, 0, 1]])
    onto = MATRIX @ np.column_stack([rotation[:, :2], translation]) @ to_board
    picture = cv2.warpPerspective(sheet, onto, SIZE, borderValue=120)
    points = cv2.projectPoints(board.points, TILT, translation, MATRIX, None)[0].reshape(-1, 2)
    return cv2.GaussianBlur(picture, (0, 0), 0.7), points


def camera(
    playwright: Playwright, url: str, folder: Path, rate: int = 20, board: Board | None = None
) -> AbstractContextManager[Page]:
    """Give a page in a Chromium whose camera shows a board, by default the default one."""
    picture = cv2.cvtColor(board_seen(board or Board())[0], cv2.COLOR_GRAY2BGR)
    return stop_and_go.camera(playwright, url, stop_and_go.write(folder / "board.y4m", [picture] * 4, rate))
