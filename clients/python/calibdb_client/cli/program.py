"""The program: arguments, commands, exit status."""

import argparse
import difflib
import os
import sys
from collections.abc import Iterable, Sequence

from .. import __version__
from ..errors import CalibDBError
from . import (
    board,
    calibrate,
    check,
    completion,
    database,
    export,
    live,
    lookup,
    plot,
    priors,
    rig,
    undistort,
)
from .output import Output

STATUSES = """examples:
  calibdb calibrate photos/ --offline -o camera.yaml --format ros
  calibdb rig left/ right/ --offline -o rig.yaml
  calibdb lookup 0 --size 1280x720 --format opencv -o camera.yml
  calibdb plot camera.json -o report.html

exit status:
  0 done · 1 nothing is known, there is no such thing, or it does not fit · 2 an argument cannot be used
  3 the service does not answer · 4 the token is refused · 5 the plan's calls are used up
  6 the camera cannot be used · 7 the pictures do not suffice · 130 interrupted

CALIBDB_URL and CALIBDB_TOKEN stand for --url and --token."""
_INTERRUPTED = 130


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    program = argparse.ArgumentParser(
        prog="calibdb",
        description="Camera calibrations of the database that browsers use.",
        epilog=STATUSES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    program.add_argument("--version", action="version", version=f"calibdb {__version__}")
    commands = program.add_subparsers(dest="command", metavar="COMMAND")
    for add in (
        *(
            lookup.add,
            priors.add,
            calibrate.add,
            rig.add,
            live.add,
            calibrate.add_submit,
            check.add,
            plot.add,
        ),
        *(undistort.add, database.add, export.add, board.add, completion.add),
    ):
        add(commands)
    return program


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit status."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    program = parser()
    if not words:
        program.print_help()
        return 0
    commands = completion.commands_of(program)
    if words[0] not in commands and (near := _near(words[0], commands)):
        print(f"calibdb: there is no command {words[0]!r}. Did you mean {near!r}?", file=sys.stderr)
        return 2
    chosen, unknown = program.parse_known_args(words)
    if unknown:
        command = commands.get(chosen.command or "", program)
        near = _near(unknown[0].partition("=")[0], completion.options_of(command))
        hint = f". Did you mean {near}?" if near else ""
        program.error(f"unrecognized arguments: {' '.join(unknown)}{hint}")
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


def _near(word: str, names: Iterable[str]) -> str | None:
    near = difflib.get_close_matches(word, list(names), 1, 0.6)
    return near[0] if near else None
