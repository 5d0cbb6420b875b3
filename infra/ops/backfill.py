"""Recomputation of every outdated consensus, as the state machine `BackfillMachine` does on AWS.

For after a release with a new model, a better solver or other thresholds. Whatever is up to date costs a few
reads and is left as it is, so it can be stopped and run again at any time.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from calibdb.errors import UnavailableError
from calibdb.schema import DISTORTION_MODELS, BackfillAnswer, RefitRequest
from functions.backfill.app import handler
from infra.ops.context import CALIBRATIONS_PREFIX, OpsContext

BATCH_SIZE = 1000  # names that the state machine hands on together


@dataclass(frozen=True)
class BackfillResult:
    """Numbers of modes (cameras at one size and zoom), and of consensuses that changed or failed."""

    modes: int
    changed: int
    failed: int


def backfill(context: OpsContext, after: str = "", *, dry_run: bool = False) -> BackfillResult:
    """Bring every consensus up to date.

    Parameters
    ----------
    context
        The deployment.
    after
        Key of a camera: it and those before it, in the order of the keys, are left out.
    dry_run
        Only list what would be checked.
    """
    changed = failed = 0
    requests = list(_all_requests(context, after))
    if dry_run:
        for request in requests:
            context.echo(f"{_describe(request)}: would be checked")
        return BackfillResult(len(requests), 0, 0)
    for request in context.track(requests, "consensuses", len(requests)):
        count = _refit(context, request)
        failed += count is None
        changed += count or 0
        context.echo(f"{_describe(request)}: {'failed' if count is None else f'{count} changed'}")
    return BackfillResult(len(requests), changed, failed)


def _all_requests(context: OpsContext, after: str) -> Iterator[RefitRequest]:
    """Yield one request for each mode of each camera."""
    names = context.track(context.objects.names(CALIBRATIONS_PREFIX), "listing")
    chosen = (name for name in names if not after or name.split("/")[1] > after)
    done: RefitRequest | None = None
    for batch in _batches(chosen):
        for request in _requests(batch):
            if request != done:  # on the border of two batches
                done = request
                yield request


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


def _requests(names: Iterable[str]) -> Iterator[RefitRequest]:
    items = {"Items": [{"Key": name} for name in names]}
    yield from BackfillAnswer.model_validate(handler(items, None)).requests


def _batches(names: Iterable[str]) -> Iterator[list[str]]:
    names = iter(names)
    while batch := list(itertools.islice(names, BATCH_SIZE)):
        yield batch
