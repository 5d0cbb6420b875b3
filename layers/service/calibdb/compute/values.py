"""Documents as the solver's values, and time for its work."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

import numpy as np

from calibdb.errors import CalibdbError
from calibdb.schema.board import Board as BoardDocument
from calibdb.schema.fields import ImgSize, Pixel
from calibsolver import FIT_VERSION, Board, Camera, DeadlineError, View, deadline

__all__ = ["FIT_VERSION", "Budget", "board_of", "camera_of", "in_time", "time_limit", "views_of"]

time_limit = deadline.limit


class CameraValues(Protocol):
    """Document with the parameters of a camera."""

    @property
    def img_size(self) -> ImgSize: ...

    @property
    def distortion_model(self) -> str: ...

    @property
    def camera_matrix(self) -> Sequence[Sequence[float]]: ...

    @property
    def distortion_coefficients(self) -> Sequence[float]: ...


class ViewValues(Protocol):
    """Document with the corners of one view."""

    @property
    def ids(self) -> Sequence[int]: ...

    @property
    def points(self) -> Sequence[Pixel]: ...


class Budget(Protocol):
    """Request or invocation that has so much time."""

    def seconds_left(self) -> float:
        """Return the s left to compute."""

    def out_of_time(self, error: CalibdbError) -> CalibdbError:
        """Return the error of a computation that did not end: `error`, if it never would."""


@contextmanager
def in_time(budget: Budget, late: CalibdbError) -> Iterator[None]:
    """Compute within a budget; raises `late`, or UnavailableError if the machine was busy."""
    try:
        with deadline.limit(budget.seconds_left):
            yield
    except DeadlineError as error:
        raise budget.out_of_time(late) from error


def board_of(document: BoardDocument) -> Board:
    """Convert a board; raises ValueError for one that cannot exist."""
    return Board.from_record(document.model_dump())


def camera_of(document: CameraValues) -> Camera:
    """Convert the camera of a fit or calibration; raises CalibrationError for an unknown model."""
    return Camera(
        document.distortion_model,
        np.asarray(document.camera_matrix, dtype=np.float64),
        np.asarray(document.distortion_coefficients, dtype=np.float64),
        document.img_size,
    )


def views_of(board: Board, documents: Sequence[ViewValues]) -> list[View]:
    """Convert the corners of views; raises ValueError for ids that are not on the board."""
    return [board.view(document.ids, document.points) for document in documents]
