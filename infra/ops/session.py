"""One run of a command: storage that is open, output, and an exit status."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from infra.console.output import Output
from infra.console.progress import track

if TYPE_CHECKING:
    from infra.ops.context import OpsContext


@dataclass(frozen=True)
class Run:
    """Storage and output of a running command."""

    context: OpsContext
    output: Output


@contextmanager
def open_run(*, as_json: bool = False) -> Iterator[Run]:
    """Open the deployment that the environment names, for one command.

    An error ends the command with its text and the exit status 1.
    """
    # Here and not above: help and completion need none of it, and the stack puts the layers on the path.
    from infra.local import LocalStack
    from infra.local.environment import storage_is_elsewhere
    from infra.local.journal import JournalError
    from infra.local.secrets import SecretsError

    logging.basicConfig(format="%(message)s")
    output = Output(as_json=as_json)
    data_dir = None if storage_is_elsewhere(os.environ) else Path(os.environ.get("DATA_DIR") or ".data")
    try:
        with LocalStack(data_dir) as stack:
            from calibdb.errors import CalibdbError
            from infra.ops.context import OpsContext

            known = stack.embedded or "CONTRIBUTOR_SECRET" in os.environ
            context = OpsContext.of(stack.environment, secret_known=known, echo=output.line, track=track)
            try:
                yield Run(context, output)
            except CalibdbError as error:
                raise _failure_exit(error.detail) from error
            output.finish()
    except BrokenPipeError:
        # Who reads has read enough. What is left in the buffer must not be written at the end either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(0) from None
    except (JournalError, SecretsError, ValueError, OSError) as error:
        raise _failure_exit(str(error)) from error


def _failure_exit(detail: str) -> typer.Exit:
    print(f"calibDB: {detail}", file=sys.stderr)
    return typer.Exit(1)
