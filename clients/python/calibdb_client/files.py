"""Files that are read and written as a whole."""

import os
from dataclasses import dataclass, field
from pathlib import Path

from .errors import UsageError

MAX_BYTES = 64 * 1024 * 1024
"""Bytes of a file that is read."""


def write_whole(path: Path, content: bytes) -> None:
    """Write a file as a whole or not at all. Raises UsageError if it cannot be written."""
    partial = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        partial.write_bytes(content)
        partial.replace(path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise UsageError(f"{path} cannot be written: {error.strerror or error}") from None


def read_whole(path: Path) -> bytes:
    """Read a file. Raises UsageError if it cannot be read, or is too large to be a calibration."""
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise UsageError(f"{path} cannot be read: {error.strerror or error}") from None
    if len(content) > MAX_BYTES:
        raise UsageError(f"{path} is larger than {MAX_BYTES >> 20} MB")
    return content


@dataclass(frozen=True)
class ExportedFile:
    """A calibration as another tool's file.

    Attributes
    ----------
    error
        px, largest distance between the projections by the calibration and by the file; 0: exact.
    coverage
        Share of the image in which the file's model is valid.
    warning
        Note for its reader, or "".
    """

    content: bytes = field(repr=False)
    filename: str
    media_type: str = "application/octet-stream"
    error: float = 0.0
    coverage: float = 1.0
    warning: str = ""
