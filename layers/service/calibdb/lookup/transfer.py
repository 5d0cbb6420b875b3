"""Transfer of a calibration to the size or zoom of a lookup, by verified relations only.

A camera scales or crops its smaller pictures, or both. A relation is verified if the lens draws the same
picture in both, over all of the part that both show.
"""

import functools
import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from calibdb.estimate.projection import axis_focal, distort_ray, rays_in_view
from calibdb.schema import Adapted, Calibration, ConsensusDocument, LookupAnswer, Uncertainty
from calibdb.schema.calibration import Relation
from calibdb.schema.fields import Row

_MIN_EVIDENCE = 2  # calibrations at an unreliable size that verify a relation
_MAX_FOCAL_RATIO = 2.0  # between two interpolated zooms
_MAX_ASPECT_LOG = 0.01  # 854x480 and 1280x720 differ by 0.0007, 4:3 and 5:4 by 0.065
# Of the width: agreeing calibrations of one camera differ by a third of that, rms over the image.
_MAX_PICTURE_RMS = 0.003
_MAX_UNCERTAINTY = 0.0015  # of the width, of a calibration that verifies or refutes
_MAX_CENTER_SHIFT = 0.02  # of the width: principal points of good calibrations vary by a hundredth
_MAX_OVERHANG = 0.02  # of a side by which a crop may stick out
_MIN_SCALE_LOG = 0.03  # by which "scale+crop" differs from the plain ones, or is a bad fit of these
_MIN_COMMON_RAYS = 40  # rays that both must see


@dataclass(frozen=True)
class Window:
    """A picture made from another: scaled by `sx`, `sy`, then cut to the middle `size`."""

    sx: float
    sy: float
    size: tuple[int, int]


def build_answer(
    found: Calibration, consensuses: Sequence[ConsensusDocument], img_size: tuple[int, int]
) -> LookupAnswer:
    """Answer with `found`, its relation to the requested size, and verified intrinsics there."""
    at = {
        c.img_size: c
        for c in consensuses
        if (c.zoom, c.distortion_model) == (found.zoom, found.distortion_model) and c.calibration
    }
    relation, adapted = _relate_and_adapt(found, at, img_size)
    exact = found.img_size == img_size
    return LookupAnswer(**{**dict(found), "exact_size": exact}, relation=relation, adapted=adapted)


def interpolate_zoom(lower: Calibration, upper: Calibration, zoom: float) -> LookupAnswer:
    """Interpolate linearly to `zoom`; as certain as the less certain calibration."""
    t = (zoom - lower.zoom) / (upper.zoom - lower.zoom)

    def mix(one: float, other: float) -> float:
        return one + t * (other - one)

    rows = zip(lower.camera_matrix, upper.camera_matrix, strict=True)
    (a, b, c), (d, e, f), last = (tuple(map(mix, one, other)) for one, other in rows)
    matrix = ((a, b, c), (d, e, f), (last[0], last[1], last[2]))
    distortion = tuple(map(mix, lower.distortion_coefficients, upper.distortion_coefficients))
    changed = {
        "camera_matrix": matrix,
        "distortion_coefficients": distortion,
        "zoom": zoom,
        "id": None,
        "calibrations": min(lower.calibrations, upper.calibrations),
        "contributors": min(lower.contributors, upper.contributors),
        "calibration_time": min(lower.calibration_time, upper.calibration_time),
        "avg_reprojection_error": max(lower.avg_reprojection_error, upper.avg_reprojection_error),
        "uncertainty": Uncertainty(
            rms=max(lower.uncertainty.rms, upper.uncertainty.rms),
            max=max(lower.uncertainty.max, upper.uncertainty.max),
            inside=_both(max, lower.uncertainty.inside, upper.uncertainty.inside),
            covered=_both(min, lower.uncertainty.covered, upper.uncertainty.covered),
        ),
        "spread": _both(max, lower.spread, upper.spread),
        "held_out_error": _both(max, lower.held_out_error, upper.held_out_error),
        "systematic": _both(max, lower.systematic, upper.systematic),
    }
    adapted = Adapted(
        img_size=lower.img_size,
        zoom=zoom,
        camera_matrix=matrix,
        distortion_coefficients=distortion,
        interpolated=True,
    )
    return LookupAnswer(**{**dict(lower), **changed}, relation=None, adapted=adapted)


def bracketing_zooms(
    consensuses: Sequence[ConsensusDocument], img_size: tuple[int, int], zoom: float, model: str
) -> tuple[Calibration, Calibration] | None:
    """Reliable calibrations at the next zooms below and above; None if they do not interpolate.

    The focal lengths must grow over all calibrated zooms, and not double from one to the next. None also if
    calibrations disagree at this zoom. Zoom 0 is unknown.
    """
    if any((c.img_size, c.zoom, c.reason) == (img_size, zoom, "disagree") for c in consensuses):
        return None
    here = sorted(
        (
            c.calibration
            for c in consensuses
            if c.calibration
            and c.reliable
            and c.zoom
            and (c.img_size, c.distortion_model) == (img_size, model)
        ),
        key=lambda c: c.zoom,
    )
    steps = list(itertools.pairwise(here))
    around = [pair for pair in steps if pair[0].zoom < zoom < pair[1].zoom]
    if not around or not all(ratio > 1 for pair in steps for ratio in _focal_ratios(*pair)):
        return None
    return around[0] if max(_focal_ratios(*around[0])) <= _MAX_FOCAL_RATIO else None


@functools.lru_cache(maxsize=256)
def relate(one: Calibration, other: Calibration) -> tuple[Relation | None, Window | None]:
    """Relation of two sizes of one camera, and how `other`'s picture is made from `one`'s.

    No relation of uncertain calibrations; no window if `other` shows more than `one`. Cached: a comparison
    takes a millisecond.
    """
    (w, h), (ow, oh) = one.img_size, other.img_size
    if any(c.uncertainty.rms > _MAX_UNCERTAINTY * c.img_size[0] for c in (one, other)):
        return None, None
    fitted = _fit_scale(one, other)
    if fitted is None:
        return "neither", None
    candidates: list[tuple[Relation, float, float]] = []
    if _same_aspect(one.img_size, other.img_size):
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


def transfer_intrinsics(one: Calibration, window: Window) -> tuple[tuple[Row, Row, Row], tuple[float, ...]]:
    """Camera matrix and distortion of the picture that `window` makes from `one`'s.

    Pixel centres are whole numbers, so c' = (c + ½) s − ½ − o.
    """
    (fx, skew, cx), (_, fy, cy), _ = one.camera_matrix
    (w, h), (ow, oh) = one.img_size, window.size
    x = (cx + 0.5) * window.sx - 0.5 - (window.sx * w - ow) / 2
    y = (cy + 0.5) * window.sy - 0.5 - (window.sy * h - oh) / 2
    matrix = ((fx * window.sx, skew * window.sx, x), (0.0, fy * window.sy, y), (0.0, 0.0, 1.0))
    return matrix, one.distortion_coefficients


def closeness(size: tuple[int, int], requested: tuple[int, int]) -> tuple[bool, float, float]:
    """Sort key of sizes: the same first, then by aspect, then by area."""
    aspect = 0.0 if _same_aspect(size, requested) else _aspect_log(size, requested)
    area = abs(math.log(size[0] * size[1] / (requested[0] * requested[1])))
    return size != requested, aspect, area


def _same_aspect(one: tuple[int, int], other: tuple[int, int]) -> bool:
    return _aspect_log(one, other) < _MAX_ASPECT_LOG


def _aspect_log(one: tuple[int, int], other: tuple[int, int]) -> float:
    return abs(math.log(one[0] * other[1] / (one[1] * other[0])))


def _focal_ratios(one: Calibration, other: Calibration) -> tuple[float, float]:
    """Ratios of the focal lengths at the axis, `other` to `one`, along x and y."""
    fx, fy = axis_focal(one)
    other_fx, other_fy = axis_focal(other)
    return other_fx / fx, other_fy / fy


def _relate_and_adapt(
    found: Calibration, at: dict[tuple[int, int], ConsensusDocument], requested: tuple[int, int]
) -> tuple[Relation | None, Adapted | None]:
    here = at.get(requested)
    if here is not None and found.img_size != requested:
        # Too few to be reliable, but enough to verify a relation.
        if here.reason == "disagree" or not here.calibration or here.calibration.calibrations < _MIN_EVIDENCE:
            return None, None
        relation, window = relate(found, here.calibration)
        return relation, _adapted_to(found, window, requested) if window else None
    others = [
        c.calibration for size, c in at.items() if c.reliable and c.calibration and size != found.img_size
    ]
    if not others:
        return None, None
    if found.img_size != requested:
        # A size that was never calibrated shows the same as two sizes around it that do. Beyond them many a
        # camera begins to cut.
        alike = sorted(
            (c for c in (found, *others) if _same_aspect(c.img_size, requested)), key=lambda c: c.img_size[0]
        )
        lower = [c for c in alike if c.img_size[0] < requested[0]]
        upper = [c for c in alike if c.img_size[0] > requested[0]]
        if lower and upper and found in alike and relate(lower[-1], upper[0])[0] == "scale":
            (w, h), (width, height) = found.img_size, requested
            window = Window(width / w, height / h, requested)
            return "scale", _adapted_to(found, window, requested)
    closest = min(others, key=lambda c: closeness(c.img_size, found.img_size))
    return relate(found, closest)[0], None


def _adapted_to(calibration: Calibration, window: Window, img_size: tuple[int, int]) -> Adapted:
    matrix, distortion = transfer_intrinsics(calibration, window)
    return Adapted(
        img_size=img_size, zoom=calibration.zoom, camera_matrix=matrix, distortion_coefficients=distortion
    )


def _both(choose: Callable[[float, float], float], one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else choose(one, other)


def _fit_scale(one: Calibration, other: Calibration) -> float | None:
    """Scale that takes `one`'s picture closest to `other`'s."""
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
    """Points of either picture, px from the principal points, and weights of rays that both see.

    Rays are as dense on every circle, so weights are radii.
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
