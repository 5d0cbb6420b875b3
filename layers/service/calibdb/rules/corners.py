"""Validation of corners: ids against the board, points against the image."""

from __future__ import annotations

from collections.abc import Sequence

from calibdb.errors import MAX_FIELD_ERRORS, FieldError, InvalidError
from calibdb.schema.board import Board
from calibdb.schema.observed_corners import ObservedCorners

_EDGE_PX = 0.5  # px; a pixel centre at 0 reaches from -0.5 to 0.5


def require_corners(board: Board, img_size: tuple[int, int], views: Sequence[ObservedCorners]) -> None:
    """Raise InvalidError for views with corners that the board does not have, or outside the image."""
    wrong = [
        error
        for n, view in enumerate(views)
        for error in corner_errors(board, img_size, view.ids, view.points, f"views.{n}.")
    ]
    if wrong:
        raise InvalidError(wrong[:MAX_FIELD_ERRORS])


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
