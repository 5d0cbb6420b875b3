"""The command as `python -m calibdb_client`."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
