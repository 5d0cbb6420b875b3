"""Recomputation of every outdated consensus, as the state machine `BackfillMachine` does on AWS.

An up-to-date consensus costs a few reads, so the command can be stopped and run again at any time.
"""

from typing import Annotated

import typer

from calibdb.errors import UnavailableError
from calibdb.schema import DISTORTION_MODELS, RefitRequest
from functions.backfill.app import requests_of
from infra.console import track
from infra.ops.context import CALIBRATIONS_PREFIX, OpsContext
from infra.ops.reindex import raise_failed
from infra.ops.session import DryRun, Json, open_run


def _describe(request: RefitRequest) -> str:
    return f"{request.camera} {request.img_size[0]}x{request.img_size[1]}"


def _refit(context: OpsContext, request: RefitRequest) -> int | None:
    """Ask for one mode, model by model; return how many consensuses changed, None if it failed."""
    before = {
        consensus.distortion_model: consensus.basis
        for consensus in context.store.consensuses.of(request.camera)
        if (consensus.img_size, consensus.zoom) == (request.img_size, request.zoom)
    }
    changed = 0
    try:
        for model in DISTORTION_MODELS:
            answer = context.store.refit.now(request.model_copy(update={"models": (model,)}))
            changed += sum(
                1 for c in answer.models.values() if c and before.get(c.distortion_model) != c.basis
            )
    except UnavailableError:
        return None
    return changed


def backfill_command(
    after: Annotated[str, typer.Option(metavar="KEY", help="Continue after this camera.")] = "",
    dry_run: DryRun = False,
    as_json: Json = False,
) -> None:
    """Recompute outdated consensuses: after a new model, another solver or other thresholds."""
    with open_run(as_json=as_json) as (context, output):
        names = track(context.objects.names(CALIBRATIONS_PREFIX), "listing")
        chosen = [name for name in names if not after or name.split("/")[1] > after]
        requests = requests_of(context.store.calibrations, chosen)  # one for each mode of each camera
        changed = failed = 0
        if dry_run:
            for request in requests:
                output.line(f"{_describe(request)}: would be checked")
            output.line(f"{len(requests)} modes of cameras would be checked")
        else:
            for request in track(requests, "consensuses", len(requests)):
                count = _refit(context, request)
                failed += count is None
                changed += count or 0
                output.line(f"{_describe(request)}: {'failed' if count is None else f'{count} changed'}")
            output.line(f"{len(requests)} modes of cameras checked, {changed} consensuses computed")
        output.value({"modes": len(requests), "changed": changed, "failed": failed})
        raise_failed(failed)
