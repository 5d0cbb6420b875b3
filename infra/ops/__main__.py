"""The operator's command line: `python -m infra.ops`.

It acts on the local stack's DATA_DIR (default .data/), whose server must be stopped; or, with
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
from infra.ops.parser import parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Execute a command line; the exit status is 1 for a failure, 2 for a wrong command line."""
    logging.basicConfig(format="%(message)s")
    asked = parser().parse_args(arguments)
    data_dir = None if storage_is_elsewhere(os.environ) else Path(os.environ.get("DATA_DIR") or ".data")
    try:
        with LocalStack(data_dir) as stack:
            # Here and not above: the stack has put the layers on the path.
            from calibdb.errors import CalibdbError
            from infra.ops.context import OpsContext

            try:
                known = stack.embedded or "CONTRIBUTOR_SECRET" in os.environ
                asked.func(OpsContext.of(stack.environment, secret_known=known), asked)
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
