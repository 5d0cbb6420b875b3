"""Answers of the service: to a lookup, and files."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from .calibration import Calibration

Source = Literal["cache", "edge", "service"]


@dataclass(frozen=True)
class Answer:
    """Answer to a lookup.

    Attributes
    ----------
    calibration
        None if nothing reliable is known.
    reason
        Word for why there is none: ``unknown_camera``, ``too_few``, ``disagree`` or
        ``few_contributors``; else "".
    detail
        The reason in a sentence.
    guidance_url
        Page that calibrates the camera in a browser; "" if there is a calibration.
    source
        Place of the answer: this machine's cache, the edge, or the service.
    """

    calibration: Calibration | None
    reason: str = ""
    detail: str = ""
    guidance_url: str = ""
    source: Source = "service"


@dataclass(frozen=True)
class ExportedFile:
    """A calibration as another tool's file.

    Attributes
    ----------
    content, filename, media_type
        As a download needs them.
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
