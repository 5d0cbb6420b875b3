"""Relation of the fields of view at two sizes: aspect, crop and zoom.

A mode of another aspect keeps the height (slope 1), the width (slope 0), or something between.
"""

import math

from calibdb.estimate.angles import Size

# Slope of log tan(hfov / 2) by the log of the aspect, its standard deviation over models with both aspects
# (docs/estimates.md), and the deviation between two sizes of one aspect.
SLOPES: dict[str, tuple[float, float, float]] = {
    "usb_webcam": (0.85, 0.3, 0.015),
    "laptop_builtin": (0.6, 0.4, 0.03),
    "webcam": (0.75, 0.4, 0.03),
    "virtual": (0.75, 0.4, 0.1),
    "camera_module": (0.2, 0.6, 0.2),
    "depth_camera": (0.75, 0.35, 0.03),
    "phone_rear": (0.1, 0.08, 0.01),  # of phones since 2015
    "phone_front": (0.25, 0.2, 0.02),
    "phone_ultrawide": (0.12, 0.25, 0.02),
    "phone_tele": (0.12, 0.25, 0.02),
    "phone_video": (0.3, 0.3, 0.05),
    "tablet_rear": (0.1, 0.2, 0.02),
    "tablet_front": (0.25, 0.2, 0.02),
    "action": (0.3, 0.4, 0.05),
    "drone": (0.3, 0.4, 0.05),
    "headset": (0.3, 0.4, 0.05),
    "photo_camera": (0.0, 0.1, 0.01),
}
_SAME_ASPECT_LOG = 0.03  # 1280x720 and 854x480 are one aspect; so are 4:3 and 1.31
_ZOOM_SIGMA = 0.03, 0.1  # at any zoom, and per unit of its logarithm
_PERCENT = 100  # zooms from here are percents, as Logitech's drivers count
_MAX_FACTOR = 20


def aspect_log(size: Size) -> float:
    """Logarithm of the longer side over the shorter."""
    return math.log(max(size) / min(size))


def is_same_aspect(one: Size, other: Size) -> bool:
    """True if two sizes have one aspect, upright or not."""
    return abs(aspect_log(one) - aspect_log(other)) < _SAME_ASPECT_LOG


def transfer(kind: str, size: Size, other: Size, *, same_size: bool = False) -> tuple[float, float]:
    """Change of `log_tan` along the longer side from `size` to `other`, and its standard deviation."""
    slope, sigma, size_sigma = SLOPES[kind]
    change = aspect_log(other) - aspect_log(size)
    if abs(change) < _SAME_ASPECT_LOG:
        return 0.0, 0.0 if same_size else size_sigma
    return slope * change, math.hypot(sigma * change, size_sigma)


def zoom_change(zoom: float) -> tuple[float, float]:
    """Change of `log_tan` by a track's zoom, and its standard deviation; 0 and 1 change nothing."""
    factor = zoom / _PERCENT if zoom >= _PERCENT else zoom
    if not 1 < factor <= _MAX_FACTOR:
        # 0: not reported. Below 1: an ultra-wide camera. Beyond: of no known unit.
        return 0.0, 0.0 if zoom in (0, 1, _PERCENT) else 0.4
    always, by_log = _ZOOM_SIGMA
    return -math.log(factor), always + by_log * math.log(factor)
