"""Commands that bring the index and the consensuses up to date."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated

import typer

from infra.ops import OpsError
from infra.ops.options import DryRun, Json
from infra.ops.session import open_run


def reindex(dry_run: DryRun = False, as_json: Json = False) -> None:
    """Rebuild the index from the bucket, the source of truth."""
    with open_run(as_json=as_json) as run:
        from infra.ops.reindex import reindex

        done = reindex(run.context, dry_run=dry_run)
        run.output.value(asdict(done))
        if dry_run:
            run.output.line(
                f"{done.calibrations} calibrations, {done.votes} votes, {done.tokens} tokens to index; "
                f"{done.published} calibrations to publish, {done.removed} stale entries to remove"
            )
            return
        run.output.line(
            f"{done.calibrations} calibrations indexed, {done.published} of them published only now; "
            f"{done.votes} votes, {done.tokens} tokens, {done.sessions} sessions, {done.rigs} rigs; "
            f"{done.consensuses} consensuses computed, {done.removed} stale entries removed"
        )
        _raise_failed(done.failed)


def backfill(
    after: Annotated[str, typer.Option(metavar="KEY", help="Continue after this camera.")] = "",
    dry_run: DryRun = False,
    as_json: Json = False,
) -> None:
    """Recompute outdated consensuses: after a new model, another solver or other thresholds."""
    with open_run(as_json=as_json) as run:
        from infra.ops.backfill import backfill

        done = backfill(run.context, after, dry_run=dry_run)
        run.output.value(asdict(done))
        if dry_run:
            run.output.line(f"{done.modes} modes of cameras would be checked")
            return
        run.output.line(f"{done.modes} modes of cameras checked, {done.changed} consensuses computed")
        _raise_failed(done.failed)


def _raise_failed(modes: int) -> None:
    if modes:
        raise OpsError(f"the consensus of {modes} modes could not be computed; run the command again")
