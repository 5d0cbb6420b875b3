"""The calibDB server: pages, API and database in one process."""

import gc
import os
import sys
from pathlib import Path


def serve() -> int:
    """Run `calibdb-server`."""
    gc.disable()  # loading creates much and drops nothing; `main` enables it
    _find_library()
    from infra.server.command import main

    return main()


def operate() -> int:
    """Run `calibdb-ops`."""
    _find_library()
    from infra.ops.__main__ import main

    return main()


def _find_library() -> None:
    """Let this process and those that it starts import the program, next to no other package."""
    library = str(Path(__file__).parent / "library")
    sys.path.insert(0, library)
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, (library, os.environ.get("PYTHONPATH"))))
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # a worker is a process
