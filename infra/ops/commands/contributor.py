"""Commands about contributors."""

from __future__ import annotations

import sys
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from infra.console import confirm
from infra.ops import OpsError
from infra.ops.options import DryRun, Json, Yes
from infra.ops.session import Run, open_run

if TYPE_CHECKING:
    from infra.ops.withdrawal import ForgetResult

app = typer.Typer(help="Remove the data of contributors.", no_args_is_help=True)


@app.callback()
def contributor() -> None:
    """Keep `forget` a verb of its own, although it is the only one."""


@app.command("forget")
def forget(
    contributor_id: Annotated[
        str | None,
        typer.Argument(metavar="ID", help="As `camera show` prints it; its first 12 digits are enough."),
    ] = None,
    address: Annotated[str | None, typer.Option(help="Instead: the IP address of the contributor …")] = None,
    token: Annotated[
        str | None, typer.Option(help="… and the id of the token; without it, all tokens are tried.")
    ] = None,
    receipt: Annotated[
        str | None, typer.Option(help="Instead: what the privacy page keeps for who made a calibration.")
    ] = None,
    dry_run: DryRun = False,
    yes: Yes = False,
    as_json: Json = False,
) -> None:
    """Remove everything that a contributor sent, for good."""
    with open_run(as_json=as_json) as run:
        from infra.ops import withdrawal

        contributors = _find(run, contributor_id, address, token, receipt)
        ask = not yes and sys.stdin.isatty()
        if dry_run or ask:
            counted = withdrawal.forget(run.context, contributors, dry_run=True)
            description = _describe(counted)
            run.output.value(asdict(counted))
            if dry_run:
                run.output.line(f"would be removed: {description}")
                return
            confirm(f"Remove {description} for good?", yes=yes)
        done = withdrawal.forget(run.context, contributors)
        run.output.line(f"removed {_describe(done)}")
        run.output.value(asdict(done))


def _describe(counts: ForgetResult) -> str:
    return (
        f"{counts.calibrations} calibrations, {counts.sessions} sessions, {counts.votes} votes, "
        f"{counts.rigs} rigs"
    )


def _find(
    run: Run, contributor_id: str | None, address: str | None, token: str | None, receipt: str | None
) -> set[str]:
    """Find the contributors that are meant; raises OpsError if nothing came from them."""
    from infra.ops import withdrawal

    if contributor_id is not None and address is receipt is None:
        return {withdrawal.find_contributor(run.context, contributor_id)}
    if receipt is not None and address is contributor_id is None:
        return withdrawal.find_contributors_by_receipt(run.context, receipt)
    if address is None or contributor_id is not None or receipt is not None:
        raise OpsError("name either a contributor, an address, or a receipt")
    if not run.context.secret_known:
        raise OpsError("set CONTRIBUTOR_SECRET: without it, addresses cannot be matched with contributors")
    if matches := withdrawal.find_contributors_at(run.context, address, token):
        return matches
    raise OpsError("nothing came from there")
