"""Withdrawal of calibrations, and removal of everything that a contributor sent; their commands."""

import sys
from collections import Counter
from dataclasses import asdict, dataclass
from typing import Annotated

import typer

from calibdb.access.tokens import SessionIds, contributor
from calibdb.camera_key import current_key
from calibdb.rules.session_result import calibration_name
from calibdb.schema import CalibrationDocument, RigDocument, SessionDocument
from calibdb.store import StreamMode
from calibdb.store.keys import calibration_object, tombstone_object, vote_object
from calibdb.store.rigs import rig_calibration_object
from infra.console import confirm, track
from infra.ops import OpsError, reindex
from infra.ops.context import OpsContext
from infra.ops.public_dump import replace_dumps
from infra.ops.session import DryRun, Json, Yes, open_run

calibration_app = typer.Typer(help="Withdraw, restore and unname single calibrations.", no_args_is_help=True)
Ids = Annotated[list[str], typer.Argument(metavar="ID", help="As `camera show` prints them.")]
contributor_app = typer.Typer(help="Remove the data of contributors.", no_args_is_help=True)
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

    def __str__(self) -> str:
        return (
            f"{self.calibrations} calibrations, {self.sessions} sessions, {self.votes} votes, "
            f"{self.rigs} rigs"
        )


def _get(context: OpsContext, calibration_id: str) -> CalibrationDocument:
    document = context.store.calibrations.get(calibration_id)
    if document is None:
        raise OpsError(f"there is no calibration {calibration_id}")
    return document


def _find_contributor(context: OpsContext, start: str) -> str:
    if len(start) < _MIN_DIGITS:
        raise OpsError(f"give at least {_MIN_DIGITS} digits of the contributor's id")
    matches = {one for one in _contributors(context) if one.startswith(start.lower())}
    if len(matches) != 1:
        raise OpsError(f"{len(matches) or 'no'} contributors begin with {start}")
    return matches.pop()


def _find_contributors_by_receipt(context: OpsContext, receipt: str) -> set[str]:
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
    for rig in list(track(context.store.rigs.all(), "rigs")):
        if _contributors_of_rig(rig) & contributors:
            if not dry_run:
                context.store.rigs.purge(rig.rig)
            counts["rigs"] += 1
    for finished in list(context.store.rigs.calibrations()):
        if set(finished.contributors) & contributors:
            purge(rig_calibration_object(finished.id))
            counts["rigs"] += 1
    for session in list(track(context.store.sessions.all(), "sessions")):
        if _contributors_of(session) & contributors:
            if not dry_run:
                context.store.sessions.purge(session.session)
            counts["sessions"] += 1
    for document, _ in list(context.every_calibration()):
        if document.contributor in contributors:
            purge(calibration_object(document.id))
            purge(tombstone_object(document.id))
            affected.add(reindex.mode_of(document))
            counts["calibrations"] += 1
    for vote in list(track(context.store.votes.all(), "votes")):
        if vote.contributor in contributors:
            purge(vote_object(vote.camera_key, vote.id))
            key = current_key(vote.camera_key, vote.camera, vote.platform)
            affected.add(StreamMode(key, vote.img_size, vote.zoom))
            counts["votes"] += 1
    done = ForgetResult(counts["calibrations"], counts["sessions"], counts["votes"], counts["rigs"])
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
        *(who for rig in context.store.rigs.all() for who in _contributors_of_rig(rig)),
        *(who for rig in context.store.rigs.calibrations() for who in rig.contributors),
    }


def _contributors_of_rig(rig: RigDocument) -> set[str]:
    return {member.contributor for member in rig.members if member is not None}


def _contributors_of(session: SessionDocument) -> set[str]:
    last = session.finish.contributor if session.finish else None
    return {who for who in (session.contributor, last) if who is not None}


def _refit(context: OpsContext, mode: StreamMode) -> None:
    if reindex.refit(context, mode) is None:
        raise OpsError("the consensus could not be computed; `reindex` tries again")


def _complete_reason(start: str) -> list[str]:
    return [reason for reason in ("wrong", "abuse", "privacy") if reason.startswith(start)]


@calibration_app.command("withdraw")
def withdraw_calibrations(
    ids: Ids,
    reason: Annotated[
        str,
        typer.Option(
            help="Stored with it; the API returns its first word if that is `wrong`, `abuse` or `privacy`.",
            autocompletion=_complete_reason,
        ),
    ] = "",
    dry_run: DryRun = False,
) -> None:
    """Exclude calibrations from all consensuses."""
    with open_run() as (context, output):
        for calibration_id in track(ids, "calibrations", len(ids)):
            document = _get(context, calibration_id)
            if dry_run:
                output.line(f"would be withdrawn: {calibration_id}")
                continue
            # The calibration stays, with a tombstone next to it.
            done = context.store.calibrations.withdraw(document, reason, context.now)
            _refit(context, reindex.mode_of(document))
            if not done:
                output.line("it was withdrawn before")


@calibration_app.command("unname")
def unname_calibrations(ids: Ids, dry_run: DryRun = False) -> None:
    """Remove the names that contributors gave to modes of cameras; the calibrations stay."""
    with open_run() as (context, output):
        for calibration_id in track(ids, "calibrations", len(ids)):
            name = _get(context, calibration_id).mode_name
            if dry_run:
                output.line(f"would lose its name: {calibration_id} {name or '(it has none)'}")
            elif not context.store.calibrations.remove_mode_name(calibration_id):
                output.line("it has no name")


@calibration_app.command("restore")
def restore_calibrations(ids: Ids, dry_run: DryRun = False) -> None:
    """Include withdrawn calibrations again."""
    with open_run() as (context, output):
        for calibration_id in track(ids, "calibrations", len(ids)):
            document = _get(context, calibration_id)
            tombstone = tombstone_object(calibration_id)
            if tombstone is None or context.objects.get(tombstone) is None:
                raise OpsError(f"{calibration_id} is not withdrawn")
            if dry_run:
                output.line(f"would be restored: {calibration_id}")
                continue
            context.objects.purge_all_versions([tombstone])
            mode = reindex.mode_of(document)
            # Its item is marked, and marks are permanent: a new item is made.
            context.remove_items([(mode.pk, f"CALIBRATION#{mode.text}#{calibration_id}")])
            context.store.calibrations.index(document)
            _refit(context, mode)


@contributor_app.callback()
def contributors() -> None:
    """Keep `forget` a verb of its own, although it is the only one."""


@contributor_app.command("forget")
def forget_contributor(
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
    with open_run(as_json=as_json) as (context, output):
        contributors = _find(context, contributor_id, address, token, receipt)
        ask = not yes and sys.stdin.isatty()
        if dry_run or ask:
            counted = forget(context, contributors, dry_run=True)
            output.value(asdict(counted))
            if dry_run:
                output.line(f"would be removed: {counted}")
                return
            confirm(f"Remove {counted} for good?", yes=yes)
        done = forget(context, contributors)
        output.line(f"removed {done}")
        output.value(asdict(done))


def _find(
    context: OpsContext,
    contributor_id: str | None,
    address: str | None,
    token: str | None,
    receipt: str | None,
) -> set[str]:
    if contributor_id is not None and address is receipt is None:
        return {_find_contributor(context, contributor_id)}
    if receipt is not None and address is contributor_id is None:
        return _find_contributors_by_receipt(context, receipt)
    if address is None or contributor_id is not None or receipt is not None:
        raise OpsError("name either a contributor, an address, or a receipt")
    if not context.secret_known:
        raise OpsError("set CONTRIBUTOR_SECRET: without it, addresses cannot be matched with contributors")
    # Addresses are not stored: it is hashed again, also with revoked tokens.
    tokens = [token] if token else context.store.tokens.ids()
    hashes = {contributor(context.settings.contributor_secret, address, each) for each in tokens}
    if matches := hashes & _contributors(context):
        return matches
    raise OpsError("nothing came from there")
