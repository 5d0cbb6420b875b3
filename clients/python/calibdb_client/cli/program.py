"""The program: arguments, commands, exit status. One sentence says what went wrong, and what to do."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

from .. import __version__
from ..errors import CalibDBError
from . import board, calibrate, check, database, export, lookup, resume, submit
from .output import Output

STATUSES = """exit status:
  0 done · 1 nothing is known, there is no such thing, or it does not fit · 2 an argument cannot be used
  3 the service does not answer · 4 the token is refused · 5 the plan's calls are used up
  6 the camera cannot be used · 7 the pictures do not suffice · 130 interrupted

CALIBDB_URL and CALIBDB_TOKEN stand for --url and --token."""
_INTERRUPTED = 130

_COMMANDS = (lookup, calibrate, resume, submit, check, database, export, board)


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    program = argparse.ArgumentParser(
        prog="calibdb",
        description="Camera calibrations of the database that browsers use.",
        epilog=STATUSES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    program.add_argument("--version", action="version", version=f"calibdb {__version__}")
    commands = program.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in _COMMANDS:
        module.add(commands)
    return program


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit status."""
    chosen = parser().parse_args(arguments)
    output = Output(json=getattr(chosen, "json", False))
    try:
        status: int = chosen.run(chosen, output)
        sys.stdout.flush()
    except CalibDBError as error:
        output.problem(str(error))
        return error.exit_status
    except KeyboardInterrupt:
        output.problem("interrupted")
        return _INTERRUPTED
    except BrokenPipeError:
        # The reader has seen enough. Python would complain when it flushes at the end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    return status
