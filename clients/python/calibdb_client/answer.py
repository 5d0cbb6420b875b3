"""Answer of the service to a lookup."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from .calibration import Calibration
    from .estimate import Estimate

Source = Literal["cache", "edge", "service"]


@dataclass(frozen=True)
class Answer:
    """Answer to a lookup.

    Attributes
    ----------
    calibration
        None if nothing reliable is known.
    reason
        Word for why there is none: ``unknown_camera``, ``too_few``, ``disagree``,
        ``few_contributors`` or ``imprecise``; else "".
    detail
        The reason in a sentence.
    guidance_url
        Page that calibrates the camera in a browser; "" if there is a calibration.
    source
        Place of the answer: this machine's cache, the edge, or the service.
    estimate
        Likely camera where nothing reliable is known; None if there is a calibration.
    """

    calibration: Calibration | None
    reason: str = ""
    detail: str = ""
    guidance_url: str = ""
    source: Source = "service"
    estimate: Estimate | None = None
