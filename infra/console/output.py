"""Output of a command: for a person a table, for a pipe lines, for a program JSON."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text


class Output:
    """Standard output of one command.

    `as_json`: nothing but one JSON document is written, at the end.
    """

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._value: object = None

    def line(self, text: str) -> None:
        """Write a line; none of a JSON document."""
        if not self._as_json:
            print(text)

    def value(self, value: object) -> None:
        """Set what the JSON document holds."""
        self._value = value

    def table(self, columns: Sequence[str], rows: Iterable[Sequence[object]], lines: Iterable[str]) -> None:
        """Write a table on a terminal, `lines` into a pipe or a file.

        Programs rely on the lines; a column whose name begins with `#` is aligned to the right.
        """
        if self._as_json:
            return
        if not sys.stdout.isatty():
            for line in lines:
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
        """Write the JSON document, where one is wanted."""
        if self._as_json:
            print(json.dumps(self._value, ensure_ascii=False))
        sys.stdout.flush()


def confirm(question: str, *, yes: bool) -> None:
    """Ask a person before something that cannot be taken back; ends the command at `no`.

    Programs, whose standard input is not a terminal, are not asked.
    """
    if not yes and sys.stdin.isatty():
        typer.confirm(question, abort=True, err=True)
