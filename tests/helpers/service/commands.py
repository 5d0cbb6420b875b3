"""Command lines of a test: what they print."""

import json
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import BytesIO, StringIO, TextIOWrapper
from pathlib import Path
from typing import Any

import pytest

from infra.ops.__main__ import main


class Terminal(StringIO):
    """A stream that is a terminal."""

    def isatty(self) -> bool:
        return True


@dataclass
class Printed:
    out: str
    err: str

    @property
    def document(self) -> Any:
        return json.loads(self.out)


def run(command: Callable[[Sequence[str]], int], *arguments: object, status: int = 0) -> Printed:
    """Run the command of a program."""
    out, err = TextIOWrapper(BytesIO(), "utf-8"), StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        assert command([str(argument) for argument in arguments]) == status, err.getvalue()
    out.seek(0)
    return Printed(out.read(), err.getvalue())


@dataclass
class Operator:
    """The operator's command line, on a data folder."""

    folder: Path
    printed: str = ""  # by the last command

    def __call__(self, *arguments: object, status: int = 0) -> str:
        """Output of a command, or its complaint if a status other than 0 is expected."""
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("DATA_DIR", str(self.folder))
            printed = run(main, *arguments, status=status)
        self.printed = printed.out
        return printed.err if status else printed.out

    def document(self, *arguments: object) -> Any:
        """Document that a command prints with `--json`."""
        return json.loads(self(*arguments, "--json"))
