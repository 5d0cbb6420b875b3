"""A clock for tests."""

from dataclasses import dataclass


@dataclass
class Clock:
    """Clock that stands until a test sets it."""

    now: float = 1_700_000_000.0

    def __call__(self) -> float:
        return self.now
