"""The command of the Python client."""

import shlex

from calibdb_client.cli import main


def calibdb(line: str, *words: str) -> int:
    """Run a command line, to which words are appended as they are, and return its exit status."""
    return main([*shlex.split(line), *words])
