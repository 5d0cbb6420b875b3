"""The budget table: rows, and how a measurement is taken."""

import statistics
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """One line of the table: `measured` and `budget` share `unit`; no budget, a figure without a bound."""

    what: str
    measured: float
    budget: float | None
    unit: str
    note: str = ""

    @property
    def verdict(self) -> str:
        if self.budget is None:
            return ""
        return "ok" if self.measured <= self.budget else "OVER"


def p50(action: Callable[[], object], repeat: int = 30, warm: int = 3) -> float:
    """Median wall time of `action` in ms, after `warm` runs that do not count."""
    return statistics.median(samples(action, repeat, warm))


def ratio(
    ours: Callable[[], object], peer: Callable[[], object], repeat: int = 15
) -> tuple[float, float, float]:
    """Time of `ours` over time of `peer`, run in turn so that both meet the same machine: (ratio, ms, ms)."""
    pairs = [(samples(ours, 1, 1)[0], samples(peer, 1, 1)[0]) for _ in range(repeat)]
    a, b = (statistics.median(column) for column in zip(*pairs, strict=True))
    return a / b, a, b


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


def samples(action: Callable[[], object], repeat: int, warm: int) -> list[float]:
    for _ in range(warm):
        action()
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        action()
        times.append((time.perf_counter() - start) * 1e3)
    return times


def render(rows: Iterable[Row]) -> str:
    cells = [("what", "measured", "budget", "", "note")]
    cells += [
        (
            r.what,
            f"{r.measured:.3g} {r.unit}",
            "" if r.budget is None else f"{r.budget:g} {r.unit}",
            r.verdict,
            r.note,
        )
        for r in rows
    ]
    widths = [max(len(row[i]) for row in cells) for i in range(5)]
    lines = ["| " + " | ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) + " |" for row in cells]
    lines.insert(1, "|" + "|".join("-" * (w + 2) for w in widths) + "|")
    return "\n".join(lines)
