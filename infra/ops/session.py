"""One run of a command: options, storage that is open, output, and an exit status."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from infra.console import Output

if TYPE_CHECKING:
    from calibdb.store.ports import JobName
    from infra.ops.context import OpsContext

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document, for programs.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Change nothing; say what would be done.")]
Yes = Annotated[bool, typer.Option("--yes", "-y", help="Do not ask.")]


class Size(NamedTuple):
    """Width and height in one argument; of a plain tuple typer would read two."""

    width: int
    height: int


def parse_size(text: str | Size) -> Size:
    """Parse a size such as `1280x720`."""
    if isinstance(text, Size):
        return text
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise typer.BadParameter(f"{text} is not a size such as 1280x720")
    return Size(int(width), int(height))


@contextmanager
def open_run(*, as_json: bool = False) -> Iterator[tuple[OpsContext, Output]]:
    """Open the deployment that the environment names, and the output, for one command."""
    from infra.ops.context import OpsContext

    with open_output(as_json=as_json) as output, _opened() as (environment, secret_known):
        context = OpsContext.of(environment, secret_known=secret_known, echo=output.line)
        yield context, output


@contextmanager
def open_output(*, as_json: bool) -> Iterator[Output]:
    """Open the output of a command. An error ends the command with its text and the exit status 1."""
    from calibdb.errors import CalibdbError
    from infra.server.folder import FolderError
    from infra.server.secrets import SecretsError

    logging.basicConfig(format="%(message)s")
    output = Output(as_json=as_json)
    try:
        yield output
        output.finish()
    except BrokenPipeError:
        # The reader has read enough. What is left in the buffer must not be written at the end either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(0) from None
    except (CalibdbError, FolderError, SecretsError, ValueError, OSError) as error:
        print(f"calibDB: {error.detail if isinstance(error, CalibdbError) else error}", file=sys.stderr)
        raise typer.Exit(1) from error


@contextmanager
def _opened() -> Iterator[tuple[Mapping[str, str], bool]]:
    """Open the storage that the environment names.

    Yields the variables of the functions, and whether they have the deployment's own secret.
    """
    from calibdb.settings import Settings
    from calibdb.store.ports import Storage
    from calibdb.store.storage import opened, storage_of
    from infra.server.folder import Folder
    from infra.server.server import opened_for_functions, variables, variables_set

    if not (os.environ.get("CALIBDB_STORAGE") == "aws" or "AWS_ENDPOINT_URL" in os.environ):
        folder = Folder(data_folder(), as_guest=True)
        try:
            for sentence in folder.damage:
                print(f"warning: {sentence}", file=sys.stderr)
            environment = variables(folder, os.environ.get("PUBLIC_URL", "http://127.0.0.1:8000"))
            with opened_for_functions(folder, InlineJobs(), environment):
                yield environment, True
        finally:
            folder.close()
        return
    missing = [name for name in ("TABLE_NAME", "BUCKET_NAME") if name not in os.environ]
    if missing:
        raise ValueError(f"storage is on AWS, but {' and '.join(missing)} do not say where")
    environment = {
        "SESSION_SECRETS": "none",
        "CONTRIBUTOR_SECRET": "none",
        "GUIDANCE_URL": "http://127.0.0.1:8000/",
        "REFIT_FUNCTION": "refit",
        **os.environ,
    }
    storage = storage_of(Settings.from_environment(environment))
    # Consensuses are computed here: the operator sees what fails.
    here = Storage(storage.table, storage.objects, InlineJobs(), storage.site)
    with variables_set(environment), opened(here):
        yield environment, "CONTRIBUTOR_SECRET" in os.environ


class InlineJobs:
    """`Jobs` that run at once in the caller's thread."""

    def later(self, job: JobName, payload: bytes) -> None:
        """Run the job; its failure is logged."""
        self.now(job, payload)

    def now(self, job: JobName, payload: bytes) -> bytes | None:
        """Run the job and return its result, None if it failed."""
        from infra.server.jobs import run

        return run(job, payload)


def data_folder() -> Path:
    """Return the data folder of a self-hosted server."""
    return Path(os.environ.get("DATA_DIR") or ".data")
