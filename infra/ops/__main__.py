"""`python -m infra.ops`: the operator's command line.

It acts on the local stack's DATA_DIR (default .data/), whose server must be stopped meanwhile; or, with
CALIBDB_STORAGE=aws and the deployment's TABLE_NAME and BUCKET_NAME in the environment, on AWS with the
operator's own credentials.
"""

from __future__ import annotations

import argparse
import logging
import os
import secrets
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from infra.local import LocalStack
from infra.local.environment import storage_is_elsewhere
from infra.local.intrinsics import TemplateError
from infra.local.journal import JournalError


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the command line asks; return the exit status."""
    logging.basicConfig(format="%(message)s")
    asked = _parser().parse_args(arguments)
    data_dir = None if storage_is_elsewhere(os.environ) else Path(os.environ.get("DATA_DIR") or ".data")
    try:
        with LocalStack(data_dir) as stack:
            return _run(asked, stack)
    except (JournalError, TemplateError, ValueError) as error:
        print(f"calibDB: {error}", file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m infra.ops", description="The operator's command line.")
    commands = parser.add_subparsers(dest="command", required=True)
    token = commands.add_parser("token", help="API tokens").add_subparsers(dest="action", required=True)
    create = token.add_parser("create", help="issue a token; it is shown once")
    create.add_argument("--origin", action="append", default=[], help="origin that may use it; repeatable")
    create.add_argument("--plan", default="free")
    token.add_parser("list", help="show all tokens, without their secrets")
    revoke = token.add_parser("revoke", help="forget a token; it is refused within a minute")
    revoke.add_argument("id")
    commands.add_parser("reindex", help="make the index of calibrations anew from the bucket")
    return parser


def _run(asked: argparse.Namespace, stack: LocalStack) -> int:
    # Here and not above: the stack has put the layers on the path.
    from calibdb.settings import Settings
    from calibdb.store import Store
    from infra.ops import tokens
    from infra.ops.reindex import reindex

    settings = Settings.from_environment(stack.environment)
    store = Store.of(settings)
    match asked.command, getattr(asked, "action", None):
        case "token", "create":
            print(tokens.create(store.tokens, asked.origin, asked.plan, int(time.time()), secrets.token_hex))
        case "token", "list":
            for token in sorted(tokens.every(store.tokens, settings.table_name), key=lambda t: t.created):
                day = time.strftime("%Y-%m-%d", time.gmtime(token.created))
                print(f"{token.id}  {day}  {token.plan}  {' '.join(token.origins) or 'any origin'}")
        case "token", "revoke":
            if (token := store.tokens.get(asked.id)) is None:
                print(f"calibDB: there is no token {asked.id}", file=sys.stderr)
                return 1
            store.tokens.revoke(token, int(time.time()))
        case "reindex", _:
            report = reindex(store, settings.table_name, print)
            print(
                f"{report.calibrations} calibrations indexed, {report.consensuses} consensuses computed, "
                f"{report.removed} stale entries removed"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
