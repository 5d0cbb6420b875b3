"""A calibration as another tool's file."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class ExportedFile:
    """A calibration as another tool's file.

    Attributes
    ----------
    content, filename, media_type
        Body, file name and media type of a download.
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
