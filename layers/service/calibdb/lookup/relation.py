"""Relation of a camera's pictures at two sizes (scale, crop, or both), verified by its calibrations at both.

A camera makes its smaller pictures by scaling the larger, by cutting out of it, or by both; which it does is
not to be guessed: of one camera 960x720 shows the same as 640x480, and 1920x1080 two thirds of it. So a
relation is *verified*: the lens must draw the same picture in both, over all of the part that both show.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

from calibdb.lookup.projection import distort_ray, is_projectable, rays_in_view
from calibdb.lookup.selection import same_aspect
from calibdb.schema import Calibration
from calibdb.schema.calibration import Relation

# Of the width, rms over the image: a hundredth of the focal length at a webcam's field of view. Calibrations
# of one camera that agree differ by a third of that.
_MAX_PICTURE_RMS = 0.003
_MAX_UNCERTAINTY = (
    0.0015  # of the width: calibrations less certain than this neither verify nor refute anything
)
_MAX_CENTER_SHIFT = 0.02  # of the width: principal points of good calibrations vary by a hundredth
_MAX_OVERHANG = 0.02  # of a side by which what is cut out may stick out
_MIN_SCALE_LOG = (
    0.03  # log by which "scale+crop" must differ from the plain ones, or it is a bad fit of these
)
_MIN_COMMON_RAYS = 40  # rays that both must see

Row = tuple[float, float, float]
Matrix = tuple[Row, Row, Row]


@dataclass(frozen=True)
class Window:
    """A picture made from another: scaled by `sx`, `sy`, then cut to the middle `size`."""

    sx: float
    sy: float
    size: tuple[int, int]


@functools.lru_cache(maxsize=256)
def relate(one: Calibration, other: Calibration) -> tuple[Relation | None, Window | None]:
    """Return the relation of two sizes of one camera, and how `other`'s picture is made from `one`'s.

    No relation where the calibrations are too uncertain to tell, or of a model without formulas here; no
    window where there is none, or where `other` shows more than `one`. Remembered: a camera in use is asked
    for again and again, and a comparison takes a millisecond.
    """
    (w, h), (ow, oh) = one.img_size, other.img_size
    if not (is_projectable(one) and is_projectable(other)):
        return None, None
    if any(c.uncertainty.rms > _MAX_UNCERTAINTY * c.img_size[0] for c in (one, other)):
        return None, None
    fitted = _fit_scale(one, other)
    if fitted is None:
        return "neither", None
    candidates: list[tuple[Relation, float, float]] = []
    if same_aspect(one.img_size, other.img_size):
        candidates.append(("scale", ow / w, oh / h))
    candidates.append(("crop", 1.0, 1.0))
    if all(abs(math.log(fitted / sx)) > _MIN_SCALE_LOG for _, sx, _ in candidates):
        candidates.append(("scale+crop", fitted, fitted))
    for relation, sx, sy in candidates:
        inside = sx * w >= ow * (1 - _MAX_OVERHANG) and sy * h >= oh * (1 - _MAX_OVERHANG)
        around = sx * w <= ow * (1 + _MAX_OVERHANG) and sy * h <= oh * (1 + _MAX_OVERHANG)
        window = Window(sx, sy, other.img_size)
        if (inside or around) and _is_verified(one, other, window):
            return relation, window if inside else None
    return "neither", None


def transfer_intrinsics(one: Calibration, window: Window) -> tuple[Matrix, tuple[float, ...]]:
    """Transfer camera matrix and distortion to the picture that `window` makes from `one`'s.

    Pixel centres are whole numbers, so a picture begins half a pixel before its first:
    c' = (c + ½) s − ½ − o.
    """
    (fx, skew, cx), (_, fy, cy), _ = one.camera_matrix
    (w, h), (ow, oh) = one.img_size, window.size
    x = (cx + 0.5) * window.sx - 0.5 - (window.sx * w - ow) / 2
    y = (cy + 0.5) * window.sy - 0.5 - (window.sy * h - oh) / 2
    matrix = ((fx * window.sx, skew * window.sx, x), (0.0, fy * window.sy, y), (0.0, 0.0, 1.0))
    return matrix, one.distortion_coefficients


def scaling_window(one: Calibration, size: tuple[int, int]) -> Window:
    """Return the window of a picture that is the same, at another size."""
    return Window(size[0] / one.img_size[0], size[1] / one.img_size[1], size)


def _fit_scale(one: Calibration, other: Calibration) -> float | None:
    """Fit the scale that takes `one`'s picture closest to `other`'s, about their principal points."""
    num = den = 0.0
    count = 0
    for (ax, ay), (bx, by), weight in _common_rays(one, other):
        num += weight * (ax * bx + ay * by)
        den += weight * (ax * ax + ay * ay)
        count += 1
    return num / den if count >= _MIN_COMMON_RAYS and num > 0 else None


def _is_verified(one: Calibration, other: Calibration, window: Window) -> bool:
    """True if `one`'s picture through `window` is `other`'s, a turn of the camera aside."""
    (_, _, cx), (_, _, cy), _ = transfer_intrinsics(one, window)[0]
    (_, _, ox), (_, _, oy), _ = other.camera_matrix
    width = other.img_size[0]
    if math.hypot(cx - ox, cy - oy) > _MAX_CENTER_SHIFT * width:
        return False
    total = sum_x = sum_y = square = 0.0
    for (ax, ay), (bx, by), weight in _common_rays(one, other):
        dx, dy = bx - window.sx * ax, by - window.sy * ay
        total += weight
        sum_x += weight * dx
        sum_y += weight * dy
        square += weight * (dx * dx + dy * dy)
    # A small turn moves the whole picture: what remains after the mean shift is what differs.
    rms = math.sqrt(max(square / total - (sum_x / total) ** 2 - (sum_y / total) ** 2, 0.0))
    return rms < _MAX_PICTURE_RMS * width


def _common_rays(
    one: Calibration, other: Calibration
) -> list[tuple[tuple[float, float], tuple[float, float], float]]:
    """Return where rays that both see meet either picture, px from the principal points.

    With a weight each: rays are as dense on every circle, so the image's area goes with the radius.
    """
    (fx, _, cx), (_, fy, cy), _ = one.camera_matrix
    (_, _, ox), (_, _, oy), _ = other.camera_matrix
    d, model = one.distortion_coefficients, one.distortion_model
    w, h = one.img_size
    out = []
    for theta, phi, (u, v) in rays_in_view(other):
        at = distort_ray(model, d, theta, phi)
        if at is None:
            continue
        x, y = at
        if -0.5 <= fx * x + cx <= w - 0.5 and -0.5 <= fy * y + cy <= h - 0.5:
            out.append(((fx * x, fy * y), (u - ox, v - oy), math.hypot(u - ox, v - oy)))
    return out
