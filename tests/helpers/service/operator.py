"""The operator's command line, on a data folder."""

import json
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from infra.ops.__main__ import main


@dataclass
class Operator:
    """Runs commands on a folder."""

    folder: Path
    printed: str = ""  # by the last command

    def __call__(self, *arguments: object, status: int = 0) -> str:
        """Output of a command, or its complaint if a status other than 0 is expected."""
        with (
            pytest.MonkeyPatch.context() as patch,
            redirect_stdout(StringIO()) as printed,
            redirect_stderr(StringIO()) as complaint,
        ):
            patch.setenv("DATA_DIR", str(self.folder))
            assert main([str(argument) for argument in arguments]) == status, complaint.getvalue()
        self.printed = printed.getvalue()
        return complaint.getvalue() if status else self.printed

    def document(self, *arguments: object) -> Any:
        """Document that a command prints with `--json`."""
        return json.loads(self(*arguments, "--json"))
