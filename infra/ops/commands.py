"""The commands, each a few lines: what was asked goes in, what was done is said."""

from __future__ import annotations

import argparse

from infra.ops import cameras, tokens, withdrawal
from infra.ops.backfill import backfill
from infra.ops.bundle import bundle
from infra.ops.context import OpsContext, OpsError
from infra.ops.reindex import reindex
from infra.ops.restore import load


def run(asked: argparse.Namespace, context: OpsContext) -> None:
    """Do what was asked; raises OpsError where it cannot be done."""
    match asked.command, getattr(asked, "action", None):
        case "token", _:
            _token(asked, context)
        case "camera", "list":
            for line in cameras.listed(context, asked.text):
                context.echo(line)
        case "camera", "show":
            for line in cameras.shown(context, asked.key):
                context.echo(line)
        case "calibration", "withdraw":
            if not withdrawal.withdraw(context, asked.id, asked.reason):
                context.echo("it was withdrawn before")
        case "calibration", "restore":
            withdrawal.restore(context, asked.id)
        case "contributor", "forget":
            _forget(asked, context)
        case "reindex", _:
            _reindex(context)
        case "backfill", _:
            _backfill(asked, context)
        case "dump", _:
            from infra.ops.dump import dump  # pyarrow takes its time

            calibrations, votes = dump(context, asked.folder)
            context.echo(f"{calibrations} calibrations and {votes} votes written to {asked.folder}")
        case "bundle", _:
            _bundle(asked, context)
        case "load", _:
            calibrations, votes = load(context, asked.folder)
            context.echo(f"{calibrations} calibrations and {votes} votes taken in")
        case "import", _:
            from infra.ops.imports import Whose, take_in  # the solver takes its time

            whose = Whose(asked.camera, asked.platform, asked.zoom)
            context.echo(take_in(context, asked.file, whose, asked.img_size, asked.squares, asked.model))
        case "seed", _:
            from infra.ops.seed import seed  # the solver takes its time

            done = seed(context, asked.file, asked.camera, asked.platform, asked.model, asked.source)
            context.echo(f"{done.rows} rows: {done.priors} first guesses for {done.cameras} cameras")
            for why, count in done.skipped.items():
                context.echo(f"{count} passed over: {why}")
        case command, _:
            raise OpsError(f"{command} is not known")


def _token(asked: argparse.Namespace, context: OpsContext) -> None:
    match asked.action:
        case "create":
            context.echo(tokens.create(context, asked.origin, asked.plan))
        case "list":
            for line in tokens.listed(context):
                context.echo(line)
        case "revoke":
            tokens.revoke(context, asked.id)
        case "rotate":
            context.echo(tokens.rotate(context, asked.id, asked.grace))


def _forget(asked: argparse.Namespace, context: OpsContext) -> None:
    if (asked.id is None) == (asked.address is None):
        raise OpsError("say either which contributor, or which address")
    if asked.id is not None:
        who = {withdrawal.named(context, asked.id)}
    elif not context.secret_known:
        raise OpsError("CONTRIBUTOR_SECRET is not set, without which no address can be told")
    else:
        who = withdrawal.at_address(context, asked.address, asked.token)
    if not who:
        raise OpsError("nothing came from there")
    done = withdrawal.forget(context, who)
    context.echo(f"removed {done.calibrations} calibrations, {done.sessions} sessions, {done.votes} votes")


def _bundle(asked: argparse.Namespace, context: OpsContext) -> None:
    done = bundle(context, asked.file, asked.most)
    for camera, size in done.cameras.items():
        context.echo(f"{size:6} bytes  {camera}")
    context.echo(
        f"{len(done.cameras)} cameras, {done.calibrations} calibrations, {done.labels} labels written to "
        f"{asked.file}: {done.size} bytes, {done.compressed} compressed"
    )


def _backfill(asked: argparse.Namespace, context: OpsContext) -> None:
    done = backfill(context, asked.after)
    context.echo(f"{done.modes} modes of cameras looked at, {done.changed} consensuses computed")
    if done.failed:
        raise OpsError(f"of {done.failed} modes the consensus could not be computed; run it again")


def _reindex(context: OpsContext) -> None:
    done = reindex(context)
    context.echo(
        f"{done.calibrations} calibrations indexed, {done.published} of them published only now; "
        f"{done.votes} votes, {done.tokens} tokens, {done.sessions} sessions; "
        f"{done.consensuses} consensuses computed, {done.removed} stale entries removed"
    )
    if done.failed:
        raise OpsError(f"of {done.failed} modes the consensus could not be computed; run it again")
