"""Calibrations that count for nothing any more, and contributors of whom nothing may be left."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

from calibdb.access.tokens import contributor
from calibdb.camera_key import current_key
from calibdb.schema import CalibrationDocument, SessionDocument
from calibdb.store import StreamMode
from calibdb.store.keys import calibration_object, tombstone_object, vote_object
from infra.ops import reindex
from infra.ops.context import OpsContext, OpsError

_SHORTEST = 12  # hex digits of a contributor that name one


@dataclass(frozen=True)
class Forgotten:
    """What was removed."""

    calibrations: int
    sessions: int
    votes: int


def withdraw(context: OpsContext, calibration_id: str, reason: str) -> bool:
    """Let a calibration count for nothing, and have the consensus computed without it.

    The calibration stays, a tombstone beside it. False when it was withdrawn before.
    """
    document = _calibration(context, calibration_id)
    done = context.store.calibrations.withdraw(document, reason, context.now)
    _refit(context, reindex.mode(document))
    return done


def restore(context: OpsContext, calibration_id: str) -> None:
    """Let a calibration that was withdrawn count again."""
    document = _calibration(context, calibration_id)
    tombstone = tombstone_object(calibration_id)
    if tombstone is None or context.objects.get(tombstone) is None:
        raise OpsError(f"{calibration_id} is not withdrawn")
    context.objects.purge_all_versions([tombstone])
    mode = reindex.mode(document)
    # Its item is marked, and nothing unmarks an item: it is made anew.
    context.index.remove([(mode.pk, f"CALIBRATION#{mode.text}#{calibration_id}")])
    context.store.calibrations.index(document)
    _refit(context, mode)


def named(context: OpsContext, start: str) -> str:
    """Return the contributor whose id begins with `start`; raises OpsError where there is not just one."""
    if len(start) < _SHORTEST:
        raise OpsError(f"a contributor is named by {_SHORTEST} digits or more")
    found = {one for one in _contributors(context) if one.startswith(start.lower())}
    if len(found) != 1:
        raise OpsError(f"{len(found) or 'no'} contributors begin with {start}")
    return found.pop()


def at_address(context: OpsContext, address: str, token_id: str | None) -> set[str]:
    """Return the contributors that someone at `address` is, with one token or with any.

    Addresses are not stored: who they are can only be told by making the keyed hash again, also with tokens
    that were revoked since.
    """
    tokens = [token_id] if token_id else context.store.tokens.ids()
    known = set(_contributors(context))
    return {contributor(context.settings.contributor_secret, address, token) for token in tokens} & known


def forget(context: OpsContext, contributors: set[str]) -> Forgotten:
    """Remove everything that these contributors sent, in every version, and what was computed from it.

    A session is theirs who started it, or sent its last view. A copy that someone made by `dump` is theirs.
    """
    affected: set[StreamMode] = set()
    counts: Counter[str] = Counter()
    # Sessions first: what is published follows from them, and must not be published again.
    for session in list(context.store.sessions.all()):
        if _whose(session) & contributors:
            context.store.sessions.purge(session.session)
            counts["sessions"] += 1
    for document, _ in list(context.store.calibrations.everything()):
        if document.contributor in contributors:
            names = (calibration_object(document.id), tombstone_object(document.id))
            context.objects.purge_all_versions([name for name in names if name])
            affected.add(reindex.mode(document))
            counts["calibrations"] += 1
    for vote in list(context.store.votes.all()):
        if vote.contributor in contributors:
            context.objects.purge_all_versions([vote_object(vote.camera_key, vote.id)])
            key = current_key(vote.camera_key, vote.camera, vote.platform)
            affected.add(StreamMode(key, vote.img_size, vote.zoom))
            counts["votes"] += 1
    # Their shares of the hour.
    used = (key for key in context.index.keys("TOKEN#") if key[1].startswith("QUOTA#"))
    context.index.remove(key for key in used if key[1].rpartition("#")[2] in contributors)
    reindex.reindex(context, only=affected)
    return Forgotten(counts["calibrations"], counts["sessions"], counts["votes"])


def _contributors(context: OpsContext) -> set[str]:
    return {
        *(document.contributor for document, _ in context.store.calibrations.everything()),
        *(vote.contributor for vote in context.store.votes.all()),
        *(who for session in context.store.sessions.all() for who in _whose(session)),
    }


def _whose(session: SessionDocument) -> set[str]:
    last = session.finish.contributor if session.finish else None
    return {who for who in (session.contributor, last) if who is not None}


def _calibration(context: OpsContext, calibration_id: str) -> CalibrationDocument:
    document = context.store.calibrations.get(calibration_id)
    if document is None:
        raise OpsError(f"there is no calibration {calibration_id}")
    return document


def _refit(context: OpsContext, mode: StreamMode) -> None:
    if reindex.refit(context, mode) is None:
        raise OpsError("the consensus could not be computed; `reindex` tries again")
