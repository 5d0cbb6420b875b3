"""Terminal: tables, progress with the time left, announced steps, questions."""

import functools
import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

ROOT = Path(__file__).resolve().parents[1]
DURATIONS = ROOT / ".build" / "durations.json"

Step = TypeVar("Step")
Item = TypeVar("Item")
Total = int | Callable[[], int] | None
"""Number of items, or how to count them, which is done only for a terminal; None: unknown."""


class Output:
    """Standard output of a command: a table for people, lines for a pipe, one JSON document for programs."""

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._value: object = None

    def line(self, text: str) -> None:
        """Write a line; none of a JSON document."""
        if not self._as_json:
            print(text)

    def value(self, value: object) -> None:
        """Set the content of the JSON document."""
        self._value = value

    def table(
        self, columns: Sequence[str], rows: Sequence[Sequence[object]], lines: Iterable[str] | None = None
    ) -> None:
        """Write a table on a terminal, `lines` into a pipe or a file: by default the rows' cells.

        Programs rely on the lines; a column whose name begins with `#` is aligned to the right.
        """
        if self._as_json:
            return
        if not sys.stdout.isatty():
            for line in ("  ".join(map(str, row)) for row in rows) if lines is None else lines:
                print(line)
            return
        table = Table()
        for column in columns:
            table.add_column(column.removeprefix("#"), justify="right" if column[0] == "#" else "left")
        for row in rows:
            # As text and not as markup: a label may hold brackets.
            table.add_row(*(Text(str(cell)) for cell in row))
        Console().print(table)

    def finish(self) -> None:
        """Write the JSON document, if one is wanted."""
        if self._as_json:
            print(json.dumps(self._value, ensure_ascii=False))
        sys.stdout.flush()


def confirm(question: str, *, yes: bool) -> None:
    """Ask a person before something irreversible; ends the command at `no`.

    Programs, whose standard input is not a terminal, are not asked.
    """
    if not yes and sys.stdin.isatty():
        typer.confirm(question, abort=True, err=True)


def track(items: Iterable[Item], what: str, total: Total = None) -> Iterator[Item]:
    """Yield the items; a bar on standard error shows how many are done and the time left."""
    if not sys.stderr.isatty():
        yield from items
        return
    number = total() if callable(total) else total
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(compact=True, elapsed_when_finished=True),
        TextColumn("left"),
        console=Console(stderr=True),
        transient=True,
        # Output of a command stands above the bar, but goes into a file as it is.
        redirect_stdout=sys.stdout.isatty(),
    ) as bar:
        task = bar.add_task(what, total=number)
        for item in items:
            yield item
            bar.advance(task)


def announce(
    work: str,
    steps: Sequence[Step],
    text: Callable[[Step], str],
    *,
    say: Callable[[str], None] = functools.partial(print, flush=True),  # noqa: B008
    clock: Callable[[], float] = time.monotonic,
    path: Path = DURATIONS,
) -> Iterator[Step]:
    """Yield the steps, each after a line with its number, its text, and the time left.

    Steps print text themselves (compilers, the SAM CLI), which would tear a bar apart. The time left is that
    of the previous run of the same steps of `work`, kept in `.build/durations.json`.
    """
    previous = _read_durations(path)
    texts = [text(step) for step in steps]
    for number, step in enumerate(steps):
        expected = [previous.get(f"{work}: {each}") for each in texts[number:]]
        say(f"{number + 1}/{len(texts)} {texts[number]}{_describe_time_left(expected)}")
        begun = clock()
        yield step
        took = {f"{work}: {texts[number]}": round(clock() - begun, 1)}
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({**_read_durations(path), **took}, indent=1), encoding="utf-8")


def format_duration(seconds: float) -> str:
    """Format a duration for people: `40 s`, `3 min`, `1 h 5 min`."""
    if seconds < 90:
        return f"{max(1, round(seconds))} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def _describe_time_left(expected: Sequence[float | None]) -> str:
    durations = [seconds for seconds in expected if seconds is not None]
    if not durations:
        return ""
    return (
        f" ({'' if len(durations) == len(expected) else 'more than '}{format_duration(sum(durations))} left)"
    )


def _read_durations(path: Path) -> dict[str, float]:
    try:
        record = dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return {}
    return {name: seconds for name, seconds in record.items() if isinstance(seconds, int | float)}
