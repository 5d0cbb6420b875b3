"""Evidence about the caller's own camera: calibrations and reports of the device."""

import math
from dataclasses import replace

from calibdb.estimate.angles import Size, log_tan, log_tan_sigma
from calibdb.estimate.crops import transfer
from calibdb.estimate.evidence import Evidence

# Standard deviation of log tan(hfov / 2) between calibrations of one camera at one size by two people.
_CALIBRATION_SIGMA = {
    "usb_webcam": 0.035,
    "webcam": 0.04,
    "laptop_builtin": 0.04,
    "virtual": 0.2,
    "camera_module": 0.04,
    "action": 0.15,
    "drone": 0.1,
    "photo_camera": 0.3,
    "phone_video": 0.1,
}
_OTHER_CALIBRATION_SIGMA = 0.02
_DISAGREE_SIGMA = 0.12
# Of a 35 mm equivalent, rounded to whole millimetres, and of a reported angle (degrees).
_REPORTED_SIGMA = {"f35": 1.3, "hfov": 2.0, "dfov": 2.5}
_FULL_PICTURE = (4.0, 3.0)  # that phones mean by their focal length


def calibrated(kind: str, value: float, count: int, *, disagree: bool = False) -> Evidence:
    """Evidence of `count` calibrations at this size; `value`: their `log_tan`."""
    sigma = _CALIBRATION_SIGMA.get(kind, _OTHER_CALIBRATION_SIGMA)
    # The camera deviates from their mean by its own deviation as well.
    spread = sigma * math.sqrt(0.5 + 0.5 / max(1, count))
    return Evidence("calibrations", value, math.hypot(spread, _DISAGREE_SIGMA) if disagree else spread)


def seen(kind: str, value: float, count: int) -> Evidence:
    """Evidence of the group of `count` calibrations that fits views."""
    return replace(calibrated(kind, value, count), basis="views")


def other_size(kind: str, value: float, size: Size, asked: Size, count: int) -> Evidence:
    """Evidence of `count` calibrations at another size; `value`: their `log_tan`."""
    change, sigma = transfer(kind, size, asked)
    return replace(calibrated(kind, value, count).shifted(change, sigma), basis="other_size")


def reported(kind: str, quantity: str, value: float, size: Size) -> Evidence:
    """Evidence of a field of view that the device reports: `f35` in mm, `hfov` or `dfov` in degrees."""
    full = _FULL_PICTURE if quantity == "f35" and kind != "photo_camera" else size
    change, sigma = transfer(kind, full, size)
    own = log_tan_sigma(quantity, value, _REPORTED_SIGMA[quantity], full)
    return Evidence("device", log_tan(quantity, value, full) + change, math.hypot(own, sigma))
