"""The commands and their names."""

from __future__ import annotations

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
application.command("import")(files.import_files)
application.command("seed")(files.seed)
