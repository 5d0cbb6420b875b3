"""A fit whose outcome is known."""

from calibdb.http.canary_capture import FOCAL, see_board
from calibsolver import Board, fit

_SEED, _IMG_SIZE = 6, (1280, 720)


def solve() -> None:
    """Fit the canary's camera to its views; raises ValueError."""
    board = Board()
    views = [board.view(ids, points) for ids, points in see_board(_SEED)]
    focal = fit(views, _IMG_SIZE).camera.matrix[0, 0]
    if not abs(focal / FOCAL - 1) < 1e-3:
        raise ValueError(f"fx is {focal} px, not {FOCAL} px")
