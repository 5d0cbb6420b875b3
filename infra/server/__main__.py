"""`python -m infra.server`, installed as `calibdb-server`: the service until a signal stops it."""

import gc
import sys

if __name__ == "__main__":
    gc.disable()  # loading creates much and drops nothing; `main` enables it
    from infra.server.command import main

    sys.exit(main())
