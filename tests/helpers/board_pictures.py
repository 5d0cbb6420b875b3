"""Pictures of a flat board, drawn as a camera without distortion sees it."""

from pathlib import Path

import cv2
import numpy as np

from calibdb_client import Board
from calibdb_client.board_sheet import png

SIZE = (640, 480)
MATRIX = np.array([[560.0, 0, 322], [0, 558.0, 237], [0, 0, 1]])
SQUARE_PX = 80
TILTS = (
    (0.5, 0.1, 0.1),
    (-0.4, 0.5, 0.0),
    (0.1, -0.6, 0.2),
    (0.0, 0.5, -0.3),
    (0.4, -0.4, 0.0),
    (-0.5, -0.2, 0.1),
)


def picture(board: Board, rvec: tuple[float, float, float], distance: float = 11.0) -> np.ndarray:
    """Grey picture (h, w) of the board, its middle before the camera at `distance` squares."""
    sheet = cv2.imdecode(np.frombuffer(png(board, SQUARE_PX), np.uint8), cv2.IMREAD_GRAYSCALE)
    # pixels of the sheet to squares: a margin of half a square, pixel centres at whole numbers
    left, top = board.edge[0] + 0.5 / SQUARE_PX - 0.5
    to_board = np.array([[1 / SQUARE_PX, 0, left], [0, 1 / SQUARE_PX, top], [0, 0, 1]])
    rotation = cv2.Rodrigues(np.array(rvec))[0]
    middle = np.array([*board.edge.mean(axis=0), 0])
    translation = np.array([0, 0, distance]) - rotation @ middle
    onto = MATRIX @ np.column_stack([rotation[:, 0], rotation[:, 1], translation]) @ to_board
    flags = {"flags": cv2.INTER_AREA, "borderValue": 200}
    seen: np.ndarray = cv2.warpPerspective(cv2.GaussianBlur(sheet, (0, 0), 0.8), onto, SIZE, **flags)
    return seen


def corners(board: Board, rvec: tuple[float, float, float], place: tuple[float, float, float]) -> np.ndarray:
    """Pixels (n, 2) of the corners of the board, its middle at a place (3,), squares."""
    rotation = cv2.Rodrigues(np.array(rvec, dtype=np.float64))[0]
    points = (board.points - [*board.edge.mean(axis=0), 0]) @ rotation.T + place
    seen: np.ndarray = points @ MATRIX.T
    return seen[:, :2] / seen[:, 2:]


def write(folder: Path, board: Board, count: int = 6) -> Path:
    """Write pictures of the board into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for n in range(count):
        tilt = TILTS[n % len(TILTS)]
        cv2.imwrite(str(folder / f"{n:02}.png"), picture(board, tilt, 9.0 + 0.8 * n))
    return folder
