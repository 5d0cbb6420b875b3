"""Validation of corners: ids against the board, points against the image."""

from __future__ import annotations

from collections.abc import Sequence

from calibdb.errors import FieldError
from calibdb.schema.board import Board

_EDGE_PX = 0.5  # px; a pixel centre at 0 reaches from -0.5 to 0.5


def corner_errors(
    board: Board,
    img_size: tuple[int, int],
    ids: Sequence[int],
    points: Sequence[tuple[float, float]],
    prefix: str = "",
) -> list[FieldError]:
    """List what is wrong, field by field; `prefix` is what the path of the fields begins with."""
    corners = board.corner_count
    width, height = img_size
    wrong = [
        FieldError(f"{prefix}ids.{i}", f"the board has corners 0 to {corners - 1}")
        for i, corner in enumerate(ids)
        if corner >= corners
    ]
    wrong += [
        FieldError(f"{prefix}points.{i}", f"outside the image of {width} x {height} px")
        for i, (x, y) in enumerate(points)
        if not (-_EDGE_PX <= x <= width - _EDGE_PX and -_EDGE_PX <= y <= height - _EDGE_PX)
    ]
    return wrong
