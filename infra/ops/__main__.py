"""`python -m infra.ops`: the operator's command line.

It acts on the local stack's DATA_DIR (default .data/), whose server must be stopped meanwhile; or, with
CALIBDB_STORAGE=aws and the deployment's TABLE_NAME and BUCKET_NAME in the environment, on AWS with the
operator's own credentials.
"""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from infra.local import LocalStack
from infra.local.environment import storage_is_elsewhere
from infra.local.intrinsics import TemplateError
from infra.local.journal import JournalError
from infra.ops.arguments import parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the command line asks; return the exit status: 1 where it could not be done, 2 for misuse."""
    logging.basicConfig(format="%(message)s")
    asked = parser().parse_args(arguments)
    data_dir = None if storage_is_elsewhere(os.environ) else Path(os.environ.get("DATA_DIR") or ".data")
    try:
        with LocalStack(data_dir) as stack:
            # Here and not above: the stack has put the layers on the path.
            from calibdb.errors import CalibdbError
            from infra.ops.commands import run
            from infra.ops.context import OpsContext

            try:
                known = stack.embedded or "CONTRIBUTOR_SECRET" in os.environ
                run(asked, OpsContext.of(stack.environment, secret_known=known))
            except CalibdbError as error:
                print(f"calibDB: {error.detail}", file=sys.stderr)
                return 1
    except BrokenPipeError:
        # Who reads has read enough. What is left in the buffer must not be written at the end either.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (JournalError, TemplateError, ValueError, OSError) as error:
        print(f"calibDB: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
