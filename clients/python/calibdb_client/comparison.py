"""Check of a calibration at hand against fresh views, on this machine or by the service."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from calibsolver.consensus.comparison import Comparison

from .checks import ask, body_of
from .errors import CaptureError, UsageError
from .flows import Flow

if TYPE_CHECKING:
    from .calibration import Calibration
    from .recording import Recording

__all__ = ["Comparison", "by_service", "compare"]

MAX_SENT_VIEWS = 5
"""Views of a check that the service takes."""


def compare(recording: Recording, calibration: Calibration) -> Comparison:
    """Compare a calibration with what a fit of the views of a recording gives.

    Raises UsageError if the pictures have another size, CaptureError if the views do not suffice.
    """
    import calibsolver
    from calibsolver.consensus import comparison

    _require_size(recording, calibration)
    try:
        views = recording.observations()
        return comparison.compare(calibration.lens, views)
    except (calibsolver.CalibrationError, ValueError) as why:
        raise CaptureError(f"the views do not suffice for a check: {why}") from None


def by_service(recording: Recording, calibration: Calibration) -> Flow[Comparison]:
    """Have the service compare; at most five views are sent, nothing is stored, and no vote counts.

    Raises UsageError if the pictures have another size.
    """
    _require_size(recording, calibration)
    names = ("img_size", "camera_matrix", "distortion_coefficients", "distortion_model")
    record = {name: calibration.record[name] for name in names}
    body = {**body_of(recording, MAX_SENT_VIEWS), "calibration": record}
    return _comparison((yield from ask(body)))


def _comparison(record: Mapping[str, Any]) -> Comparison:
    def length(name: str) -> float:
        return math.inf if record[name] is None else float(record[name])

    return Comparison(
        record["fits"] == "fits",
        length("error"),
        length("expected"),
        length("drift"),
        length("drift_uncertainty"),
        int(record["views"]),
    )


def _require_size(recording: Recording, calibration: Calibration) -> None:
    (w, h), (width, height) = recording.key.img_size, calibration.img_size
    if (w, h) != (width, height):
        raise UsageError(f"the pictures have {w} x {h} px, the calibration is of {width} x {height}")
