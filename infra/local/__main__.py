"""`python -m infra.local`: calibDB on this machine until a signal stops it."""

import gc
import sys

if __name__ == "__main__":
    # Loading makes much and drops nothing; the collector would walk all of it again and again, in a fifth
    # of the time. `main` turns it on.
    gc.disable()
    from infra.local.process import main

    sys.exit(main())
