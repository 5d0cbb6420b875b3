"""Errors of the solver, and how their messages state figures."""

from collections.abc import Iterator
from contextlib import contextmanager

from numpy.linalg import LinAlgError

MAX_FACTOR = 100.0
"""Factor from which on a number says nothing more."""


class CalibrationError(Exception):
    """Reason why there is no calibration: a stable `code` for programs, and one sentence for people."""

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code
        self.message = message


@contextmanager
def undetermined() -> Iterator[None]:
    """Raise CalibrationError ``not_believable`` if linear algebra fails in the block, or in the function.

    The given numbers leave a matrix undetermined that is singular, or whose decomposition does not converge.
    """
    try:
        yield
    except LinAlgError as error:
        raise CalibrationError("not_believable", "these views leave the camera undetermined") from error


class DeadlineError(Exception):
    """End of the time that the caller allotted (`deadline.limit`).

    It says nothing of the views, so it is not a CalibrationError: a caller of several fits must not take it
    for a fit that failed.
    """

    def __init__(self) -> None:
        super().__init__("the computation takes longer than the time allotted")


def format_px_error(px: float, width: float, digits: int = 1) -> str:
    """Format an error, px, in an image of some width, px: beyond the width no number says more."""
    return f"{px:.{digits}f} px off" if px < width else "off by more than the image is wide"


def format_factor(factor: float) -> str:
    """Format a factor as how many times."""
    return f"{factor:.1f} times" if factor < MAX_FACTOR else "over a hundred times"
