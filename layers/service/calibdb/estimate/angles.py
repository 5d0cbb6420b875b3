"""Fields of view and focal lengths of a pinhole.

Zoom and crop add to the logarithm of the tangent of half the horizontal angle.
"""

import math
from collections.abc import Callable

Size = tuple[float, float]

MIN_LOG_TAN, MAX_LOG_TAN = math.log(math.tan(math.radians(1))), math.log(math.tan(math.radians(85)))
_FILM_DIAGONAL_MM = math.hypot(36, 24)


def _half_tangent(angle: float) -> float:
    if not 0 < angle < 180:
        raise ValueError(f"no field of view: {angle}")
    return math.tan(math.radians(angle) / 2)


def log_tan(quantity: str, value: float, size: Size) -> float:
    """Logarithm of the tangent of half the horizontal angle.

    `quantity`: `hfov`, `vfov`, `dfov` in degrees; `fx`, px; `f35`, mm: by the diagonal of 35 mm film. `size`:
    in px for `fx`, else in any unit.
    """
    return math.log(_TANGENTS[quantity](value, *size))


def log_tan_sigma(quantity: str, value: float, sigma: float, size: Size) -> float:
    """Standard deviation of `log_tan`, to first order."""
    step = 1e-3 * value
    slope = (log_tan(quantity, value + step, size) - log_tan(quantity, value - step, size)) / (2 * step)
    return abs(slope) * sigma


def horizontal_angle(log_tangent: float) -> float:
    """Horizontal field of view, limited to 2 to 170 degrees."""
    limited = min(max(log_tangent, MIN_LOG_TAN), MAX_LOG_TAN)
    return 2 * math.degrees(math.atan(math.exp(limited)))


_TANGENTS: dict[str, Callable[[float, float, float], float]] = {
    "fx": lambda v, w, _: w / (2 * v),
    "hfov": lambda v, _w, _h: _half_tangent(v),
    "vfov": lambda v, w, h: _half_tangent(v) * w / h,
    "dfov": lambda v, w, h: _half_tangent(v) * w / math.hypot(w, h),
    "f35": lambda v, w, h: _FILM_DIAGONAL_MM / (2 * v) * w / math.hypot(w, h),
}
