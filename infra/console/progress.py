"""Progress of a loop on standard error, with the time left; nothing if that is not a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

Item = TypeVar("Item")
Total = int | Callable[[], int] | None
"""Number of items, or how to count them, which is done only for a terminal; None: unknown."""


class Track(Protocol):
    """Function that shows how far a loop has come."""

    def __call__(self, items: Iterable[Item], what: str, total: Total = None) -> Iterator[Item]:
        """Yield the items; `what` names the work."""


def pass_through(items: Iterable[Item], what: str, total: Total = None) -> Iterator[Item]:
    """Yield the items and show nothing."""
    del what, total
    yield from items


def track(items: Iterable[Item], what: str, total: Total = None) -> Iterator[Item]:
    """Yield the items while a bar on standard error tells how many are done and how long the others take."""
    if not sys.stderr.isatty():
        yield from items
        return
    number = total() if callable(total) else total
    with _progress(Console(stderr=True)) as bar:
        task = bar.add_task(what, total=number)
        for item in items:
            yield item
            bar.advance(task)


def _progress(console: Console) -> Progress:
    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(compact=True, elapsed_when_finished=True),
        TextColumn("left"),
        console=console,
        transient=True,
        # What a command prints meanwhile stands above the bar; into a file it goes as it is.
        redirect_stdout=sys.stdout.isatty(),
        redirect_stderr=True,
    )
