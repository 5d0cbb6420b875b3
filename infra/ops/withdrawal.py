"""Withdrawal of calibrations, and removal of everything that a contributor sent."""

from __future__ import annotations

import functools
from collections import Counter
from dataclasses import dataclass

from calibdb.access.tokens import SessionIds, contributor
from calibdb.camera_key import current_key
from calibdb.rules.session_result import calibration_name
from calibdb.schema import CalibrationDocument, RigDocument, SessionDocument
from calibdb.store import StreamMode
from calibdb.store.keys import calibration_object, tombstone_object, vote_object
from calibdb.store.rigs import rig_calibration_object
from infra.ops import OpsError, reindex
from infra.ops.context import CALIBRATIONS_PREFIX, OpsContext, count_objects
from infra.ops.public_dump import replace_dumps

_MIN_DIGITS = 12  # hex digits of a contributor that name one
_HASH_DIGITS = 12  # at the end of a calibration's id; earlier ids have another time before them
_MAX_VERSIONS = 1_000  # of a restarted session


@dataclass(frozen=True)
class ForgetResult:
    """Numbers of removed documents."""

    calibrations: int
    sessions: int
    votes: int
    rigs: int


def withdraw(context: OpsContext, calibration_id: str, reason: str) -> bool:
    """Exclude a calibration from all consensuses, and recompute its own.

    The calibration stays, with a tombstone next to it. False if it was withdrawn before.
    """
    document = get(context, calibration_id)
    done = context.store.calibrations.withdraw(document, reason, context.now)
    _refit(context, reindex.mode_of(document))
    return done


def unname(context: OpsContext, calibration_id: str) -> bool:
    """Remove the name of the mode from a calibration; False if it has none."""
    get(context, calibration_id)
    return context.store.calibrations.remove_mode_name(calibration_id)


def get_withdrawn(context: OpsContext, calibration_id: str) -> tuple[CalibrationDocument, str]:
    """Read a withdrawn calibration and the name of its tombstone; raises OpsError if it is not one."""
    document = get(context, calibration_id)
    tombstone = tombstone_object(calibration_id)
    if tombstone is None or context.objects.get(tombstone) is None:
        raise OpsError(f"{calibration_id} is not withdrawn")
    return document, tombstone


def restore(context: OpsContext, calibration_id: str) -> None:
    """Include a withdrawn calibration again."""
    document, tombstone = get_withdrawn(context, calibration_id)
    context.objects.purge_all_versions([tombstone])
    mode = reindex.mode_of(document)
    # Its item is marked, and marks are permanent: a new item is made.
    context.remove_items([(mode.pk, f"CALIBRATION#{mode.text}#{calibration_id}")])
    context.store.calibrations.index(document)
    _refit(context, mode)


def find_contributor(context: OpsContext, start: str) -> str:
    """Find the contributor whose id begins with `start`; raises OpsError if there is not exactly one."""
    if len(start) < _MIN_DIGITS:
        raise OpsError(f"give at least {_MIN_DIGITS} digits of the contributor's id")
    matches = {one for one in _contributors(context) if one.startswith(start.lower())}
    if len(matches) != 1:
        raise OpsError(f"{len(matches) or 'no'} contributors begin with {start}")
    return matches.pop()


def find_contributors_at(context: OpsContext, address: str, token_id: str | None) -> set[str]:
    """Find the contributors at an IP address, with one token or with any.

    Addresses are not stored. They are matched by computing the keyed hash again, also with revoked tokens.
    """
    tokens = [token_id] if token_id else context.store.tokens.ids()
    contributors = set(_contributors(context))
    return {
        contributor(context.settings.contributor_secret, address, token) for token in tokens
    } & contributors


def find_contributors_by_receipt(context: OpsContext, receipt: str) -> set[str]:
    """Find the contributors of the calibration, or of the session, of which this is the session id.

    Raises OpsError if it was not signed by a key that is known, or nothing is left of its session.
    """
    sid = SessionIds(context.settings.session_secrets, lambda: context.now).sid_of(receipt.strip())
    if sid is None:
        raise OpsError("no key of SESSION_SECRETS has signed this receipt: it is forged, or the key is gone")
    hashes = {calibration_name(sid, version)[-_HASH_DIGITS:] for version in range(1, _MAX_VERSIONS + 1)}
    contributors = {
        document.contributor
        for document in context.store.calibrations.all()
        if document.id[-_HASH_DIGITS:] in hashes
    }
    sessions = (one for one in context.store.sessions.all() if one.session == sid)
    contributors |= {who for session in sessions for who in _contributors_of(session)}
    if not contributors:
        raise OpsError("nothing is left of the session of this receipt")
    return contributors


def forget(context: OpsContext, contributors: set[str], *, dry_run: bool = False) -> ForgetResult:
    """Remove everything that these contributors sent, in every version, and what was computed from it.

    A session belongs to the contributor who started it and to the one who sent its last view; a rig to all
    whose cameras are in it, and it goes with any of them, the others' calibrations stay. The dumps of
    the site are replaced; copies that others made remain. With `dry_run`, nothing is removed, only counted.
    """
    affected: set[StreamMode] = set()
    counts: Counter[str] = Counter()

    def purge(name: str | None) -> None:
        if name is not None and not dry_run:
            context.objects.purge_all_versions([name])

    # Rigs and sessions first: what is published follows from them, and must not be published again.
    for rig in list(context.track(context.store.rigs.all(), "rigs")):
        if contributors_of_rig(rig) & contributors:
            if not dry_run:
                context.store.rigs.purge(rig.rig)
            counts["running rigs"] += 1
    for finished in list(context.store.rigs.calibrations()):
        if set(finished.contributors) & contributors:
            purge(rig_calibration_object(finished.id))
            counts["rigs"] += 1
    for session in list(context.track(context.store.sessions.all(), "sessions")):
        if _contributors_of(session) & contributors:
            if not dry_run:
                context.store.sessions.purge(session.session)
            counts["sessions"] += 1
    total = functools.partial(count_objects, context, CALIBRATIONS_PREFIX)
    for document, _ in list(context.track(context.store.calibrations.everything(), "calibrations", total)):
        if document.contributor in contributors:
            purge(calibration_object(document.id))
            purge(tombstone_object(document.id))
            affected.add(reindex.mode_of(document))
            counts["calibrations"] += 1
    for vote in list(context.track(context.store.votes.all(), "votes")):
        if vote.contributor in contributors:
            purge(vote_object(vote.camera_key, vote.id))
            key = current_key(vote.camera_key, vote.camera, vote.platform)
            affected.add(StreamMode(key, vote.img_size, vote.zoom))
            counts["votes"] += 1
    done = ForgetResult(
        counts["calibrations"],
        counts["sessions"],
        counts["votes"],
        counts["running rigs"] + counts["rigs"],
    )
    if dry_run:
        return done
    # Their shares of the hour.
    used = (key for key in context.storage.table.keys("TOKEN#") if key[1].startswith("SHARE#"))
    context.remove_items(key for key in used if key[1].rpartition("#")[2] in contributors)
    reindex.reindex(context, only=affected)
    if counts["calibrations"] or counts["votes"]:
        replace_dumps(context)
    return done


def _contributors(context: OpsContext) -> set[str]:
    return {
        *(document.contributor for document, _ in context.store.calibrations.everything()),
        *(vote.contributor for vote in context.store.votes.all()),
        *(who for session in context.store.sessions.all() for who in _contributors_of(session)),
        *(who for rig in context.store.rigs.all() for who in contributors_of_rig(rig)),
        *(who for rig in context.store.rigs.calibrations() for who in rig.contributors),
    }


def contributors_of_rig(rig: RigDocument) -> set[str]:
    """List the contributors whose cameras are in a running rig."""
    return {member.contributor for member in rig.members if member is not None}


def _contributors_of(session: SessionDocument) -> set[str]:
    last = session.finish.contributor if session.finish else None
    return {who for who in (session.contributor, last) if who is not None}


def get(context: OpsContext, calibration_id: str) -> CalibrationDocument:
    """Read a calibration; raises OpsError if there is none."""
    document = context.store.calibrations.get(calibration_id)
    if document is None:
        raise OpsError(f"there is no calibration {calibration_id}")
    return document


def _refit(context: OpsContext, mode: StreamMode) -> None:
    if reindex.refit(context, mode) is None:
        raise OpsError("the consensus could not be computed; `reindex` tries again")
