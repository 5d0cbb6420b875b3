"""The operator's command line: `python -m infra.ops`, or `infra/calibdb-ops` from any folder.

It acts on a data folder (`--data DIR` or DATA_DIR, default .data), whether its server runs or not; or, with
CALIBDB_STORAGE=aws and the deployment's TABLE_NAME, BUCKET_NAME and WEB_BUCKET_NAME in the environment, on
AWS with the operator's own credentials.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence

from infra.ops.application import NAME, application

_USAGE_ERROR = 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Execute a command line; the exit status is 1 for a failure, 2 for a wrong command line."""
    try:
        application(list(sys.argv[1:] if arguments is None else arguments), prog_name=NAME)
    except SystemExit as ended:
        status = ended.code if isinstance(ended.code, int) else 0
        if status == _USAGE_ERROR:
            raise
        return status
    return 0


if __name__ == "__main__":
    sys.exit(main())
