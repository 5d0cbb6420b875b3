"""Documents as the solver's values, and time for its work."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from calibdb.errors import CalibdbError, InvalidError
from calibdb.http.call import Call
from calibdb.schema.board import Board as BoardDocument
from calibdb.schema.calibration import Intrinsics
from calibdb.schema.documents import ViewDocument
from calibdb.schema.observed_corners import ObservedCorners
from calibsolver import Board, CalibrationError, Camera, DeadlineError, View, deadline

time_limit = deadline.limit


@contextmanager
def in_time(call: Call, late: CalibdbError) -> Iterator[None]:
    """Compute in the time of a call; raises `late`, or UnavailableError on a busy machine."""
    try:
        with deadline.limit(call.seconds_left):
            yield
    except DeadlineError as error:
        raise call.out_of_time(late) from error


@contextmanager
def naming(field: str) -> Iterator[None]:
    """Raise CalibrationError as InvalidError of a field."""
    try:
        yield
    except CalibrationError as error:
        raise InvalidError.field(field, error.message) from error


def board_of(document: BoardDocument) -> Board:
    """Board of the solver; raises ValueError."""
    return Board.from_record(document.model_dump())


def camera_of(document: Intrinsics) -> Camera:
    """Camera of a fit or calibration; raises CalibrationError."""
    return Camera(
        document.distortion_model,
        np.asarray(document.camera_matrix, dtype=np.float64),
        np.asarray(document.distortion_coefficients, dtype=np.float64),
        document.img_size,
    )


def views_of(board: Board, documents: Sequence[ViewDocument | ObservedCorners]) -> list[View]:
    """Views of corners; raises ValueError for ids that are not on the board."""
    return [board.view(document.ids, document.points) for document in documents]
