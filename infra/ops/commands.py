"""The commands, each a few lines: what was asked goes in, what was done is said."""

from __future__ import annotations

import argparse

from infra.ops import cameras, tokens, withdrawal
from infra.ops.backfill import backfill
from infra.ops.bundle import bundle
from infra.ops.desk import Desk, OpsError
from infra.ops.reindex import reindex
from infra.ops.restore import load
from infra.ops.seed import seed


def run(asked: argparse.Namespace, desk: Desk) -> None:
    """Do what was asked; raises OpsError where it cannot be done."""
    match asked.command, getattr(asked, "action", None):
        case "token", _:
            _token(asked, desk)
        case "camera", "list":
            for line in cameras.listed(desk, asked.text):
                desk.say(line)
        case "camera", "show":
            for line in cameras.shown(desk, asked.key):
                desk.say(line)
        case "calibration", "withdraw":
            if not withdrawal.withdraw(desk, asked.id, asked.reason):
                desk.say("it was withdrawn before")
        case "calibration", "restore":
            withdrawal.restore(desk, asked.id)
        case "contributor", "forget":
            _forget(asked, desk)
        case "reindex", _:
            _reindex(desk)
        case "backfill", _:
            _backfill(asked, desk)
        case "dump", _:
            from infra.ops.dump import dump  # pyarrow takes its time

            calibrations, votes = dump(desk, asked.folder)
            desk.say(f"{calibrations} calibrations and {votes} votes written to {asked.folder}")
        case "bundle", _:
            _bundle(asked, desk)
        case "load", _:
            calibrations, votes = load(desk, asked.folder)
            desk.say(f"{calibrations} calibrations and {votes} votes taken in")
        case "import", _:
            from infra.ops.imports import Whose, take_in  # the solver takes its time

            whose = Whose(asked.camera, asked.platform, asked.zoom)
            desk.say(take_in(desk, asked.file, whose, asked.img_size, asked.squares, asked.model))
        case "seed", _:
            done = seed(desk, asked.file, asked.camera, asked.platform, asked.model, asked.source)
            desk.say(f"{done.rows} rows: {done.priors} first guesses for {done.cameras} cameras")
            for why, count in done.skipped.items():
                desk.say(f"{count} passed over: {why}")
        case command, _:
            raise OpsError(f"{command} is not known")


def _token(asked: argparse.Namespace, desk: Desk) -> None:
    match asked.action:
        case "create":
            desk.say(tokens.create(desk, asked.origin, asked.plan))
        case "list":
            for line in tokens.listed(desk):
                desk.say(line)
        case "revoke":
            tokens.revoke(desk, asked.id)
        case "rotate":
            desk.say(tokens.rotate(desk, asked.id, asked.grace))


def _forget(asked: argparse.Namespace, desk: Desk) -> None:
    if (asked.id is None) == (asked.address is None):
        raise OpsError("say either which contributor, or which address")
    if asked.id is not None:
        who = {withdrawal.named(desk, asked.id)}
    elif not desk.secret_known:
        raise OpsError("CONTRIBUTOR_SECRET is not set, without which no address can be told")
    else:
        who = withdrawal.at_address(desk, asked.address, asked.token)
    if not who:
        raise OpsError("nothing came from there")
    done = withdrawal.forget(desk, who)
    desk.say(f"removed {done.calibrations} calibrations, {done.sessions} sessions, {done.votes} votes")


def _bundle(asked: argparse.Namespace, desk: Desk) -> None:
    done = bundle(desk, asked.file, asked.most)
    for camera, size in done.cameras.items():
        desk.say(f"{size:6} bytes  {camera}")
    desk.say(
        f"{len(done.cameras)} cameras, {done.calibrations} calibrations, {done.labels} labels written to "
        f"{asked.file}: {done.size} bytes, {done.compressed} compressed"
    )


def _backfill(asked: argparse.Namespace, desk: Desk) -> None:
    done = backfill(desk, asked.after)
    desk.say(f"{done.modes} modes of cameras looked at, {done.changed} consensuses computed")
    if done.failed:
        raise OpsError(f"of {done.failed} modes the consensus could not be computed; run it again")


def _reindex(desk: Desk) -> None:
    done = reindex(desk)
    desk.say(
        f"{done.calibrations} calibrations indexed, {done.published} of them published only now; "
        f"{done.votes} votes, {done.tokens} tokens, {done.sessions} sessions; "
        f"{done.consensuses} consensuses computed, {done.removed} stale entries removed"
    )
    if done.failed:
        raise OpsError(f"of {done.failed} modes the consensus could not be computed; run it again")
