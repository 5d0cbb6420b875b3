"""Check of a calibration at hand against fresh views, on this machine."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .errors import CaptureError, UsageError

if TYPE_CHECKING:
    from .calibration import Calibration
    from .recording import Recording

MAX_RMS_RATIO = 1.5
"""Error under the calibration / error under a camera fitted to the views, up to which it fits."""
MAX_EXCESS_WIDTHS = 0.15 / 1280
"""Excess of the one over the other / image width up to which it fits as well."""


@dataclass(frozen=True)
class Comparison:
    """Result of a check of a calibration at hand.

    Attributes
    ----------
    fits
        True if the calibration explains the views about as well as their own fit.
    error, expected
        px rms of the views under it, and under a camera fitted to them alone.
    drift
        px rms over the picture between the projections of the two cameras, the best rotation removed.
    drift_uncertainty
        px rms, standard deviation of the projections of the fit of these views.
    views
        Number of views.
    """

    fits: bool
    error: float
    expected: float
    drift: float
    drift_uncertainty: float
    views: int


def compare(recording: Recording, calibration: Calibration) -> Comparison:
    """Compare a calibration with what a fit of the views of a recording gives.

    Raises UsageError if the pictures have another size, CaptureError if the views do not suffice.
    """
    import calibsolver
    from calibsolver.consensus.agreement import difference
    from calibsolver.fitting.resection import reprojection_score

    camera, size = calibration.lens, recording.key.img_size
    if camera.img_size != size:
        raise UsageError(
            f"the pictures have {size[0]} x {size[1]} px, the calibration is of {camera.img_size[0]} x "
            f"{camera.img_size[1]}"
        )
    try:
        views = recording.board.views([{"ids": view.ids, "points": view.points} for view in recording.views])
        own = calibsolver.fit(views, size, camera.model, start=camera)
        used = [
            calibsolver.View(view.object_points[mask], view.image_points[mask])
            for view, mask in zip(views, own.used, strict=True)
            if mask.any()
        ]
        error = reprojection_score(camera, used).rms
        expected = reprojection_score(own.camera, used).rms
    except (calibsolver.CalibrationError, ValueError) as why:
        raise CaptureError(f"the views do not suffice for a check: {why}") from None
    limit = max(MAX_RMS_RATIO * expected, expected + MAX_EXCESS_WIDTHS * size[0])
    return Comparison(
        bool(np.isfinite(error) and error <= limit),
        float(error),
        float(expected),
        difference(camera, own.camera),
        own.uncertainty().rms,
        len(used),
    )
