"""Validation of corners: ids against the board, points against the image."""

from __future__ import annotations

from collections.abc import Sequence

from calibdb.errors import MAX_FIELD_ERRORS, FieldError, InvalidError
from calibdb.schema.board import Board
from calibdb.schema.documents import ViewDocument
from calibdb.schema.observed_corners import ObservedCorners

_EDGE_PX = 0.5  # a pixel centre at 0 reaches from -0.5 to 0.5


def require_corners(board: Board, img_size: tuple[int, int], views: Sequence[ObservedCorners]) -> None:
    """Raise InvalidError for views with corners that the board does not have, or outside the image."""
    wrong = [
        error for n, view in enumerate(views) for error in corner_errors(board, img_size, view, f"views.{n}.")
    ]
    if wrong:
        raise InvalidError(wrong[:MAX_FIELD_ERRORS])


def corner_errors(
    board: Board, img_size: tuple[int, int], view: ViewDocument | ObservedCorners, prefix: str = ""
) -> list[FieldError]:
    """Errors of the fields, whose paths begin with `prefix`."""
    corners = board.corner_count
    width, height = img_size
    wrong = [
        FieldError(f"{prefix}ids.{i}", f"the board has corners 0 to {corners - 1}")
        for i, corner in enumerate(view.ids)
        if corner >= corners
    ]
    wrong += [
        FieldError(f"{prefix}points.{i}", f"outside the image of {width} x {height} px")
        for i, (x, y) in enumerate(view.points)
        if not (-_EDGE_PX <= x <= width - _EDGE_PX and -_EDGE_PX <= y <= height - _EDGE_PX)
    ]
    return wrong
