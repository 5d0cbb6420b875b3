"""Rebuild of the index from the bucket, the source of truth."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from typing import Any, cast

from calibdb.access.plans import TRIAL_PERIOD_S
from calibdb.errors import UnavailableError
from calibdb.lookup import well_known_ids
from calibdb.rules import session_result
from calibdb.schema import CalibrationDocument, RefitRequest
from calibdb.store import Store, StreamMode, Table, endings
from calibdb.store.names import with_current_key
from calibdb.store.ports import Condition, Item
from infra.console import track
from infra.ops import OpsError
from infra.ops.context import Key, OpsContext
from infra.ops.session import DryRun, Json, open_run

# What a computation writes; all other items of a camera follow from single objects.
_COMPUTED = ("CONSENSUS", "GROUPS")


@dataclass(frozen=True)
class ReindexResult:
    """Numbers of indexed documents and computed consensuses."""

    calibrations: int
    published: int  # that a crash had left unpublished
    votes: int
    tokens: int
    sessions: int  # running ones that the index did not know
    rigs: int  # likewise
    consensuses: int
    failed: int  # modes whose consensus could not be computed
    removed: int


class _RecordingTable:
    """A table that records the keys of what it writes; with `dry_run` it writes nothing."""

    def __init__(self, table: Table, *, dry_run: bool) -> None:
        self._table = table
        self.written: set[Key] = set()
        self._dry_run = dry_run

    def __getattr__(self, name: str) -> Any:
        return getattr(self._table, name)

    def put(self, item: Item, condition: Condition | None = None) -> bool:
        key = str(item["pk"]), str(item["sk"])
        self.written.add(key)
        if self._dry_run:
            return condition is None or self._table.get(*key) is None
        return self._table.put(item, condition)

    def delete(self, pk: str, sk: str, condition: Condition | None = None) -> bool:
        return True if self._dry_run else self._table.delete(pk, sk, condition)


def reindex(
    context: OpsContext,
    only: Iterable[StreamMode] | None = None,
    *,
    dry_run: bool = False,
) -> ReindexResult:
    """Make the index name exactly what is in the bucket, and recompute outdated consensuses.

    `only`: modes whose consensus is computed again; None: all. Safe to run on a table in use, and again:
    lookups continue, with the old answers until the new ones are there. What is published while it runs is
    indexed by its own submit. Counters of use are not in the bucket and stay as they are, or restart.
    """
    # First, so that later publications are not mistaken for entries that the bucket lacks.
    indexed = set(context.storage.table.keys("CAMERA"))
    recorder = _RecordingTable(context.storage.table, dry_run=dry_run)
    recorded = replace(context.storage, table=cast("Table", recorder), objects=context.objects)
    store = Store.over(recorded)
    sessions, rigs = store.sessions.index(context.now), store.rigs.index(context.now)
    published = _publish_finished(context, dry_run=dry_run)
    modes: Counter[StreamMode] = Counter()
    for document, withdrawn in context.every_calibration():
        store.calibrations.index(document, withdrawn=withdrawn)
        modes[mode_of(document)] += not withdrawn
    votes = 0
    for vote in track(store.votes.all(), "votes"):
        store.votes.index(vote)
        votes += 1
    tokens = store.tokens.reindex(context.now, TRIAL_PERIOD_S)
    for prior in store.priors.all():
        store.priors.index(prior)
    computed = {(item.pk, item.text) for item in modes}
    stale = {key for key in indexed if key not in recorder.written and _computed_of(key) not in computed}
    if not dry_run:
        context.remove_items(stale)
    consensuses = failed = 0
    chosen = None if only is None else set(only)
    wanted_modes = [] if dry_run else [mode for mode in modes if chosen is None or mode in chosen]
    for request in track(wanted_modes, "consensuses", len(wanted_modes)):
        refitted = refit(context, request)
        failed += refitted is None
        consensuses += refitted or 0
        count = modes[request]
        context.echo(f"{request.camera_key} {request.text}: {count} calibration{'' if count == 1 else 's'}")
    return ReindexResult(
        calibrations=sum(modes.values()),
        published=published,
        votes=votes,
        tokens=tokens,
        sessions=sessions,
        rigs=rigs,
        consensuses=consensuses,
        failed=failed,
        removed=len(stale),
    )


def _publish_finished(context: OpsContext, *, dry_run: bool) -> int:
    """Publish sessions that converged but, after a crash, were not published; return how many.

    This covers clients that never return.
    """
    if not dry_run:
        for rig in track(context.store.rigs.all(), "rigs"):
            if rig.finish is not None:
                endings.end_sessions(context.store, rig, context.now)
    published = 0
    for session in track(context.store.sessions.all(), "sessions"):
        finish = session.finish
        if finish is not None and context.store.calibrations.get(finish.calibration_id) is None:
            if not dry_run:
                context.store.calibrations.publish(session_result.to_calibration(session))
            published += 1
    return published


def refit(context: OpsContext, mode: StreamMode) -> int | None:
    """Have the consensus of every model computed; return how many there are, None if it failed."""
    request = RefitRequest(camera=mode.camera_key, img_size=mode.img_size, zoom=mode.zoom)
    try:
        answer = context.store.refit.now(request)
    except UnavailableError as error:
        context.echo(f"{mode.camera_key} {mode.text}: {error.detail}")
        return None
    # A computation with nothing new leaves this as it is, and here it may have been lost.
    well_known_ids.refresh_well_known(context.store, mode.camera_key, context.settings.thresholds)
    return sum(1 for consensus in answer.models.values() if consensus is not None)


def mode_of(document: CalibrationDocument) -> StreamMode:
    """Get camera, size and zoom of a calibration, under today's key."""
    return StreamMode(with_current_key(document).camera_key, document.img_size, document.zoom)


def _computed_of(key: Key) -> tuple[str, str] | None:
    """Parse partition and text of the mode that the item was computed for, None for other items."""
    pk, sk = key
    kind, _, rest = sk.partition("#")
    return (pk, rest.rpartition("#")[0]) if kind in _COMPUTED else None


def reindex_command(dry_run: DryRun = False, as_json: Json = False) -> None:
    """Rebuild the index from the bucket, the source of truth."""
    with open_run(as_json=as_json) as (context, output):
        done = reindex(context, dry_run=dry_run)
        output.value(asdict(done))
        if dry_run:
            output.line(
                f"{done.calibrations} calibrations, {done.votes} votes, {done.tokens} tokens to index; "
                f"{done.published} calibrations to publish, {done.removed} stale entries to remove"
            )
            return
        output.line(
            f"{done.calibrations} calibrations indexed, {done.published} of them published only now; "
            f"{done.votes} votes, {done.tokens} tokens, {done.sessions} sessions, {done.rigs} rigs; "
            f"{done.consensuses} consensuses computed, {done.removed} stale entries removed"
        )
        raise_failed(done.failed)


def raise_failed(modes: int) -> None:
    """Raise OpsError if the consensus of modes could not be computed."""
    if modes:
        raise OpsError(f"the consensus of {modes} modes could not be computed; run the command again")
