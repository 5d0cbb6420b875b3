"""Commands about single calibrations."""

from __future__ import annotations

from typing import Annotated

import typer

from infra.ops.options import DryRun, complete_reason
from infra.ops.session import open_run

app = typer.Typer(help="Withdraw, restore and unname single calibrations.", no_args_is_help=True)
Ids = Annotated[list[str], typer.Argument(metavar="ID", help="As `camera show` prints them.")]


@app.command("withdraw")
def withdraw(
    ids: Ids,
    reason: Annotated[
        str,
        typer.Option(
            help="Stored with it; the API returns its first word if that is `wrong`, `abuse` or `privacy`.",
            autocompletion=complete_reason,
        ),
    ] = "",
    dry_run: DryRun = False,
) -> None:
    """Exclude calibrations from all consensuses."""
    with open_run() as run:
        from infra.ops import withdrawal

        for calibration_id in run.context.track(ids, "calibrations", len(ids)):
            if dry_run:
                withdrawal.get(run.context, calibration_id)
                run.output.line(f"would be withdrawn: {calibration_id}")
            elif not withdrawal.withdraw(run.context, calibration_id, reason):
                run.output.line("it was withdrawn before")


@app.command("unname")
def unname(ids: Ids, dry_run: DryRun = False) -> None:
    """Remove the names that contributors gave to modes of cameras; the calibrations stay."""
    with open_run() as run:
        from infra.ops import withdrawal

        for calibration_id in run.context.track(ids, "calibrations", len(ids)):
            if dry_run:
                name = withdrawal.get(run.context, calibration_id).mode_name
                run.output.line(f"would lose its name: {calibration_id} {name or '(it has none)'}")
            elif not withdrawal.unname(run.context, calibration_id):
                run.output.line("it has no name")


@app.command("restore")
def restore(ids: Ids, dry_run: DryRun = False) -> None:
    """Include withdrawn calibrations again."""
    with open_run() as run:
        from infra.ops import withdrawal

        for calibration_id in run.context.track(ids, "calibrations", len(ids)):
            if dry_run:
                withdrawal.get_withdrawn(run.context, calibration_id)
                run.output.line(f"would be restored: {calibration_id}")
            else:
                withdrawal.restore(run.context, calibration_id)
