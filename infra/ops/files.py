"""Reader of calibration files on disk."""

from __future__ import annotations

from pathlib import Path

from calibsolver import CalibrationError
from calibsolver.formats import ImportedFile
from calibsolver.formats.base import ReaderOptions
from calibsolver.formats.reading import read_bytes
from infra.ops import OpsError

_MAX_JSON_BYTES = 64 * 2**20  # bytes; keypoints make files large


def read_file(path: Path, options: ReaderOptions = ReaderOptions()) -> ImportedFile:  # noqa: B008 - a value that never changes
    """Read a calibration file of any kind that `calibsolver.formats.reading` knows.

    Raises OpsError, which says what is wrong with it.
    """
    try:
        return read_bytes(_bytes(path), path.suffix, options)
    except CalibrationError as error:
        raise OpsError(f"{path}: {error}") from error


def _bytes(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            raw = file.read(_MAX_JSON_BYTES + 1)
    except OSError as error:
        raise OpsError(f"{path} cannot be read: {error.strerror}") from error
    if len(raw) > _MAX_JSON_BYTES:
        raise OpsError(f"{path} is larger than {_MAX_JSON_BYTES >> 20} MB")
    return raw
