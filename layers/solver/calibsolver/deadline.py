"""Deadline of a computation: time that the caller allots, checked in every loop that may be long.

The solver has no clock: the caller says how many seconds are left. If none are, the loop raises
DeadlineError, and nothing is half done.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

from .errors import DeadlineError

SecondsLeft = Callable[[], float]
T = TypeVar("T")

_seconds_left: ContextVar[SecondsLeft | None] = ContextVar("seconds_left", default=None)


@contextmanager
def limit(seconds_left: SecondsLeft) -> Iterator[None]:
    """Limit the computations of the block: `seconds_left` returns s, 0 or less when the time is up.

    A limit around the block also applies.
    """
    outer = _seconds_left.get()
    bounded = seconds_left if outer is None else lambda: min(outer(), seconds_left())
    reset = _seconds_left.set(bounded)
    try:
        yield
    finally:
        _seconds_left.reset(reset)


def compute_within(seconds: float, compute: Callable[[], T], otherwise: T) -> T:
    """Compute an optional value: `otherwise` if it takes more than so many s of the time left.

    Unlimited without a limit. Raises DeadlineError if all of the time is up.
    """
    outer = _seconds_left.get()
    if outer is None:
        return compute()
    end = outer() - seconds
    try:
        with limit(lambda: outer() - end):
            return compute()
    except DeadlineError:
        check()
        return otherwise


def check() -> None:
    """Raise DeadlineError if the time is up."""
    seconds_left = _seconds_left.get()
    if seconds_left is not None and seconds_left() <= 0:
        raise DeadlineError
