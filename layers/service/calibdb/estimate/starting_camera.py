"""Initial camera of a capture, estimated by published facts: unreliable calibrations may be of another."""

from __future__ import annotations

import math

from calibdb.estimate.estimator import EstimateQuery, estimate
from calibdb.schema import FitRecord, Uncertainty

_ZEROS = {"rectilinear": 5, "rational": 8, "fisheye": 4}  # coefficients of a lens without distortion


def starting_camera(query: EstimateQuery, model: str) -> FitRecord | None:
    """Return the estimate as a camera of this model; None for an omnidirectional one."""
    if model not in _ZEROS:
        return None
    likely = estimate(query)
    w = likely.img_size[0]
    (focal, _, cx), (_, _, cy), last = likely.camera_matrix
    low, high = (math.radians(angle) for angle in likely.interval_90.hfov_deg)
    theta = math.radians(likely.hfov_deg) / 2
    distortion = (0.0,) * _ZEROS[model]
    if model == likely.distortion_model:
        distortion = likely.distortion_coefficients
    elif model == "fisheye":  # equidistant
        focal = w / 2 / theta
    else:
        focal = w / 2 / math.tan(theta)
    error = (high - low) / 4 * focal  # px, about two thirds of the way to the edge
    return FitRecord(
        img_size=likely.img_size,
        camera_matrix=((focal, 0.0, cx), (0.0, focal, cy), last),
        distortion_coefficients=distortion,
        distortion_model=model,
        avg_reprojection_error=0.0,
        uncertainty=Uncertainty(rms=error, max=2 * error),
    )
