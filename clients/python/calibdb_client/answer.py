"""Answer of the service to a lookup: a calibration, or an estimate, which never is one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from .calibration import Calibration, CameraRecord
from .errors import UsageError

Source = Literal["cache", "edge", "service"]


@dataclass(frozen=True)
class Answer:
    """Answer to a lookup.

    Attributes
    ----------
    calibration
        None if nothing reliable is known.
    reason, detail
        Word for why there is none, and a sentence: ``unknown_camera``, ``too_few``, ``disagree``,
        ``few_contributors`` or ``imprecise``.
    guidance_url
        Page that calibrates the camera in a browser; "" if there is a calibration.
    source
        Place of the answer: this machine's cache, the edge, or the service.
    estimate
        Likely camera; None if there is a calibration.
    """

    calibration: Calibration | None
    reason: str = ""
    detail: str = ""
    guidance_url: str = ""
    source: Source = "service"
    estimate: Estimate | None = None


@dataclass(frozen=True, eq=False)
class Estimate(CameraRecord):
    """Estimated camera with the interval of its field of view (docs/estimates.md).

    Its model is `rectilinear` or `fisheye`, or that of a calibration that it rests on.

    Raises UsageError for a record that is not an estimate.
    """

    def __post_init__(self) -> None:
        try:
            low, high = self.record["interval_90"]["hfov_deg"]
            whole = float(low) <= float(self.record["hfov_deg"]) <= float(high)
            whole = whole and np.asarray(self.record["camera_matrix"], dtype=np.float64).shape == (3, 3)
        except (KeyError, TypeError, ValueError):
            whole = False
        if not whole:
            raise UsageError("not an estimate: camera_matrix, hfov_deg and interval_90 are needed")

    def __repr__(self) -> str:
        low, high = self.interval_90
        return f"Estimate({self.hfov_deg:.1f} degrees, 90 %: {low:.1f} to {high:.1f}, {self.basis})"

    @property
    def hfov_deg(self) -> float:
        """Horizontal field of view, degrees."""
        return float(self.record["hfov_deg"])

    @property
    def interval_90(self) -> tuple[float, float]:
        """Horizontal fields of view, degrees, between which the true one lies with a probability of 90 %."""
        low, high = self.record["interval_90"]["hfov_deg"]
        return float(low), float(high)

    @property
    def basis(self) -> str:
        """Best evidence of the estimate, such as `published` or `population`."""
        return str(self.record.get("basis", ""))

    @property
    def group(self) -> str | None:
        """Name of the group of calibrations that fits the views sent, such as ``78°``; None otherwise."""
        group = self.record.get("group")
        return None if group is None else str(group)

    @property
    def sources(self) -> tuple[tuple[str, str], ...]:
        """Titles and addresses of the publications that it rests on."""
        return tuple((str(each["title"]), str(each["url"])) for each in self.record.get("sources", ()))
