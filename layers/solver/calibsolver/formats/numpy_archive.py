"""Archives of numpy arrays (.npz), as scripts after OpenCV's Python tutorials write them. No pickles."""

import io
import zipfile
from typing import Any

import numpy as np

from ..errors import CalibrationError
from . import text

MAX_ARCHIVE_BYTES = 64_000_000
"""That an archive may unpack to."""
MAX_ARRAY_NUMBERS = 100
"""Of an array that is looked at: a camera's are small."""


def parse(raw: bytes) -> dict[str, Any]:
    """Return the small arrays by name, as lists; CalibrationError ``malformed``."""
    result: dict[str, Any] = {}
    pickled = []
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            if not all(info.filename.endswith(".npy") for info in archive.infolist()):
                raise text.refuse("the file is a ZIP archive: unpack it and give the calibration file in it")
            if sum(info.file_size for info in archive.infolist()) > MAX_ARCHIVE_BYTES:
                raise text.refuse("the archive is too large")
        with np.load(io.BytesIO(raw), allow_pickle=False) as arrays:
            for name in arrays.files:
                try:
                    array = arrays[name]
                except ValueError:
                    pickled.append(name)
                    continue
                if array.dtype.kind in "fiub" and array.size <= MAX_ARRAY_NUMBERS:
                    result[name] = array.tolist()
                elif array.dtype.kind == "U" and array.size == 1:
                    result[name] = str(array.item())[:200]
    except CalibrationError:
        raise
    except Exception as error:  # noqa: BLE001 - parsers of ZIP, deflate and Python raise a dozen types
        raise text.refuse(f"the file is not an archive of numpy arrays: {type(error).__name__}") from None
    if not result and pickled:
        raise text.refuse(
            f"the arrays {', '.join(pickled[:5])} are pickled objects, which may run code and are not read: "
            "save plain arrays"
        )
    return result
