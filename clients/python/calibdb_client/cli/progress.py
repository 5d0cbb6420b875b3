"""Progress on standard error: a bar in a terminal, else a line from time to time."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

LINES_EVERY_S = 5.0


@contextmanager
def progress(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show how many of how many are done, as long as the block lasts."""
    if not sys.stderr.isatty():
        yield _lines(what)
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as shown:
        task = shown.add_task(what, total=None)
        yield lambda done, count: shown.update(task, completed=done, total=count)


def _lines(what: str) -> Callable[[int, int], None]:
    written = time.monotonic()

    def advance(done: int, count: int) -> None:
        nonlocal written
        if time.monotonic() - written >= LINES_EVERY_S:
            written = time.monotonic()
            print(f"{what}: {done} of {count}", file=sys.stderr, flush=True)

    return advance
