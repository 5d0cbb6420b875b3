"""The budget table: rows, and how a measurement is taken."""

import statistics
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import cv2

from tests.bench import document


@dataclass(frozen=True)
class Row:
    """One line of the table: `measured` and `budget` share `unit`; no budget, a figure without a bound."""

    what: str
    measured: float
    budget: float | None
    unit: str
    note: str = ""

    def cells(self) -> list[str]:
        measured = f"{self.measured:.3g} {self.unit}"
        if self.budget is None:
            return [self.what, measured, "", "", self.note]
        verdict = "ok" if self.measured <= self.budget else "OVER"
        return [self.what, measured, f"{self.budget:g} {self.unit}", verdict, self.note]


def render(rows: Iterable[Row]) -> str:
    return document.table(["what", "measured", "budget", "", "note"], [row.cells() for row in rows])


def p50(action: Callable[[], object], repeat: int = 30) -> float:
    """Median wall time of `action` in ms, after three runs that do not count."""
    for _ in range(3):
        action()
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        action()
        times.append((time.perf_counter() - start) * 1e3)
    return statistics.median(times)


def least_times(
    ours: Callable[[], object], peer: Callable[[], object], repeat: int = 7
) -> tuple[float, float]:
    """Least processor times of this thread, run in turn, s: other programs disturb these least."""

    def once(action: Callable[[], object]) -> float:
        begun = time.thread_time()
        action()
        return time.thread_time() - begun

    pairs = [(once(ours), once(peer)) for _ in range(repeat)]
    mine, theirs = (min(column) for column in zip(*pairs, strict=True))
    return mine, theirs


@contextmanager
def one_thread() -> Iterator[None]:
    """Let OpenCV use one thread in the block."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)
