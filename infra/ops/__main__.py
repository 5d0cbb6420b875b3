"""The operator's command line: `python -m infra.ops`, or `infra/calibdb-ops` from any folder.

It acts on a data folder (`--data DIR` or DATA_DIR, default .data), whether its server runs or not; or, with
CALIBDB_STORAGE=aws and the deployment's TABLE_NAME, BUCKET_NAME and WEB_BUCKET_NAME in the environment, on
AWS with the operator's own credentials.
"""

import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

import typer

from infra.ops import backfill, cameras, files, reindex, tokens, withdrawal

_USAGE_ERROR = 2
NAME = "calibdb-ops"

application = typer.Typer(
    name=NAME,
    help="The operator's command line of calibDB.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@application.callback()
def choose(
    data: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Data folder of a server, in use or not.")
    ] = None,
) -> None:
    """Choose the deployment."""
    if data is not None:
        os.environ["DATA_DIR"] = str(data)


application.add_typer(tokens.app, name="token")
application.add_typer(cameras.app, name="camera")
application.add_typer(withdrawal.calibration_app, name="calibration")
application.add_typer(withdrawal.contributor_app, name="contributor")
_COMMANDS: dict[str, Callable[..., None]] = {
    "reindex": reindex.reindex_command,
    "backfill": backfill.backfill_command,
    "dump": files.dump,
    "publish-dump": files.publish_dump,
    "load": files.load,
    "bundle": files.bundle,
    "backup": files.backup,
    "restore": files.restore,
    "import": files.import_files,
    "seed": files.seed,
}
for name, command in _COMMANDS.items():
    application.command(name)(command)


def main(arguments: Sequence[str] | None = None) -> int:
    """Execute a command line; the exit status is 1 for a failure, 2 for a wrong command line."""
    try:
        application(list(sys.argv[1:] if arguments is None else arguments), prog_name=NAME)
    except SystemExit as ended:
        status = ended.code if isinstance(ended.code, int) else 0
        if status == _USAGE_ERROR:
            raise
        return status
    return 0


if __name__ == "__main__":
    sys.exit(main())
