"""Files that are there as a whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

from .errors import UsageError


def write_whole(path: Path, content: bytes) -> None:
    """Write a file as a whole or not at all. Raises UsageError if it cannot be written."""
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        partial.write_bytes(content)
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise UsageError(f"{path} cannot be written: {error.strerror or error}") from None
