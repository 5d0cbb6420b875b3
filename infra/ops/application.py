"""The commands and their names."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from infra.ops.commands import calibration, camera, contributor, files, token, upkeep

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


application.add_typer(token.app, name="token")
application.add_typer(camera.app, name="camera")
application.add_typer(calibration.app, name="calibration")
application.add_typer(contributor.app, name="contributor")
application.command("reindex")(upkeep.reindex)
application.command("backfill")(upkeep.backfill)
application.command("dump")(files.dump)
application.command("publish-dump")(files.publish_dump)
application.command("load")(files.load)
application.command("bundle")(files.bundle)
application.command("backup")(files.backup)
application.command("restore")(files.restore)
application.command("import")(files.import_files)
application.command("seed")(files.seed)
