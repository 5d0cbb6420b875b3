"""Reader of calibration files on disk."""

from __future__ import annotations

from pathlib import Path

from calibdb.rules.calibration_file import FormError, parse
from calibsolver import CalibrationError
from calibsolver.formats import ImportedFile
from calibsolver.formats.reader_options import ReaderOptions
from calibsolver.formats.reading import READERS, is_text_kind
from infra.ops.errors import OpsError

_MAX_JSON_BYTES = 64 * 2**20  # bytes; keypoints make files large


def read_file(path: Path, options: ReaderOptions = ReaderOptions()) -> ImportedFile:  # noqa: B008 - a value that never changes
    """Read a calibration file of any kind that `calibsolver.formats.reading` knows.

    Raises OpsError, which says what is wrong with it.
    """
    try:
        parsed = parse(_bytes(path), path.suffix, is_text_kind)
        return READERS[parsed.form](parsed.content, options)
    except (CalibrationError, FormError) as error:
        raise OpsError(f"{path}: {error}") from error
    except RecursionError:
        raise OpsError(f"{path}: nested too deeply") from None


def _bytes(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            raw = file.read(_MAX_JSON_BYTES + 1)
    except OSError as error:
        raise OpsError(f"{path} cannot be read: {error.strerror}") from error
    if len(raw) > _MAX_JSON_BYTES:
        raise OpsError(f"{path} is larger than {_MAX_JSON_BYTES >> 20} MB")
    return raw
