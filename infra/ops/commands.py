"""The operator's commands: each takes a context and the parsed arguments, and prints what it did.

A command imports its module when it runs: only then are the layers on the path, and some modules load slowly
(the solver, pyarrow).
"""

from __future__ import annotations

from argparse import Namespace
from typing import TYPE_CHECKING

from infra.ops.errors import OpsError

if TYPE_CHECKING:
    from infra.ops.context import OpsContext


def create_token(context: OpsContext, asked: Namespace) -> None:
    """Issue a token and print it."""
    from infra.ops import tokens

    context.echo(tokens.create(context, asked.origin, asked.plan))


def list_tokens(context: OpsContext, _: Namespace) -> None:
    """Print a line for each token."""
    from infra.ops import tokens

    for line in tokens.describe(context):
        context.echo(line)


def revoke_token(context: OpsContext, asked: Namespace) -> None:
    """Revoke a token."""
    from infra.ops import tokens

    tokens.revoke(context, asked.id)


def rotate_token(context: OpsContext, asked: Namespace) -> None:
    """Give a token a new secret and print it."""
    from infra.ops import tokens

    context.echo(tokens.rotate(context, asked.id, asked.grace))


def list_cameras(context: OpsContext, asked: Namespace) -> None:
    """Print a line for each camera."""
    from infra.ops import cameras

    for line in cameras.describe_all(context, asked.text):
        context.echo(line)


def show_camera(context: OpsContext, asked: Namespace) -> None:
    """Print consensuses and calibrations of one camera."""
    from infra.ops import cameras

    for line in cameras.describe(context, asked.key):
        context.echo(line)


def withdraw(context: OpsContext, asked: Namespace) -> None:
    """Withdraw a calibration."""
    from infra.ops import withdrawal

    if not withdrawal.withdraw(context, asked.id, asked.reason):
        context.echo("it was withdrawn before")


def restore(context: OpsContext, asked: Namespace) -> None:
    """Restore a withdrawn calibration."""
    from infra.ops import withdrawal

    withdrawal.restore(context, asked.id)


def forget(context: OpsContext, asked: Namespace) -> None:
    """Remove everything of one contributor, or of those at an address."""
    from infra.ops import withdrawal

    if (asked.id is None) == (asked.address is None):
        raise OpsError("name either a contributor or an address")
    if asked.id is not None:
        contributors = {withdrawal.find_contributor(context, asked.id)}
    elif not context.secret_known:
        raise OpsError("set CONTRIBUTOR_SECRET: without it, addresses cannot be matched with contributors")
    else:
        contributors = withdrawal.find_contributors_at(context, asked.address, asked.token)
    if not contributors:
        raise OpsError("nothing came from there")
    done = withdrawal.forget(context, contributors)
    context.echo(f"removed {done.calibrations} calibrations, {done.sessions} sessions, {done.votes} votes")


def reindex(context: OpsContext, _: Namespace) -> None:
    """Rebuild the index."""
    from infra.ops.reindex import reindex

    done = reindex(context)
    context.echo(
        f"{done.calibrations} calibrations indexed, {done.published} of them published only now; "
        f"{done.votes} votes, {done.tokens} tokens, {done.sessions} sessions; "
        f"{done.consensuses} consensuses computed, {done.removed} stale entries removed"
    )
    _raise_failed(done.failed)


def backfill(context: OpsContext, asked: Namespace) -> None:
    """Recompute outdated consensuses."""
    from infra.ops.backfill import backfill

    done = backfill(context, asked.after)
    context.echo(f"{done.modes} modes of cameras checked, {done.changed} consensuses computed")
    _raise_failed(done.failed)


def dump(context: OpsContext, asked: Namespace) -> None:
    """Write the database to a folder."""
    from infra.ops.dump import dump

    calibrations, votes = dump(context, asked.folder)
    context.echo(f"{calibrations} calibrations and {votes} votes written to {asked.folder}")


def load(context: OpsContext, asked: Namespace) -> None:
    """Store the content of a dump."""
    from infra.ops.restore import load

    calibrations, votes = load(context, asked.folder)
    context.echo(f"{calibrations} calibrations and {votes} votes stored")


def bundle(context: OpsContext, asked: Namespace) -> None:
    """Write the bundle for web applications."""
    from infra.ops.bundle import bundle

    done = bundle(context, asked.file, asked.most)
    for camera, size in done.cameras.items():
        context.echo(f"{size:6} bytes  {camera}")
    context.echo(
        f"{len(done.cameras)} cameras, {done.calibrations} calibrations, {done.labels} labels written to "
        f"{asked.file}: {done.size} bytes, {done.compressed} compressed"
    )


def import_file(context: OpsContext, asked: Namespace) -> None:
    """Store a calibration file of another tool."""
    from calibsolver.formats.hints import Hints
    from infra.ops.imports import ReportedCamera, import_file

    camera = ReportedCamera(asked.camera, asked.platform, asked.zoom)
    hints = Hints(asked.img_size, asked.camera_number, asked.squares)
    context.echo(import_file(context, asked.file, camera, hints, asked.model))


def seed(context: OpsContext, asked: Namespace) -> None:
    """Store published calibrations as first guesses."""
    from infra.ops.seed import seed

    done = seed(context, asked.file, asked.camera, asked.platform, asked.model, asked.source)
    context.echo(f"{done.rows} rows: {done.priors} first guesses for {done.cameras} cameras")
    for reason, count in done.skipped.items():
        context.echo(f"{count} skipped: {reason}")


def _raise_failed(modes: int) -> None:
    if modes:
        raise OpsError(f"the consensus of {modes} modes could not be computed; run the command again")
