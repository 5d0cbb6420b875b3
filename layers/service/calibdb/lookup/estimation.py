"""Estimate for a lookup that misses, by stored data and published facts."""

import math
from collections.abc import Sequence

from calibdb.camera_key import identify
from calibdb.camera_key.system import system_of
from calibdb.estimate.crops import zoom_change
from calibdb.estimate.device import device_of
from calibdb.estimate.estimator import EstimateQuery, estimate
from calibdb.estimate.evidence import Evidence
from calibdb.estimate.own import calibrated, other_size, reported, seen
from calibdb.estimate.projection import axis_focal, distort_ray
from calibdb.lookup.transfer import closeness
from calibdb.schema import Calibration, ConsensusDocument, FittingGroup, LookupRequest
from calibdb.schema.estimate import Estimate
from calibdb.schema.fields import CROPPED

_PINHOLES = ("rectilinear", "rational")
_FOCAL_SIGMA = 0.02  # of a photograph's focal length, which EXIF data round
_MAX_OTHER_SIZES = 2  # the closest; others are evidence of the same calibrations


def estimate_for(
    request: LookupRequest, known: Sequence[ConsensusDocument], fitting: FittingGroup | None = None
) -> Estimate:
    """Estimate the camera of a lookup from its unreliable consensuses.

    `fitting`: the group that fits the views sent.
    """
    kind = _kind(request) if known or request.reported else ""
    here = None if fitting else _calibration_here(request, known)
    evidence = [*_reports(request, kind), *_other_sizes(request, known, kind)]
    if fitting is not None:
        evidence.append(seen(kind, _log_tan(fitting.calibration), fitting.calibration.calibrations))
    if here is not None and here.calibration is not None:
        count, disagree = here.calibration.calibrations, here.reason == "disagree"
        value = _log_tan(here.calibration)
        evidence.append(calibrated(kind, value, count, disagree=disagree))
    result = estimate(
        EstimateQuery(
            request.camera,
            request.platform,
            request.img_size,
            request.zoom,
            cropped=request.resize_mode == CROPPED,
            evidence=tuple(evidence),
        )
    )
    if result.basis == "calibrations" and here is not None and here.calibration is not None:
        return _with_lens_of(result, here.calibration)
    if fitting is not None and result.basis == "views":
        likely = _with_lens_of(result, fitting.calibration)
        return likely.model_copy(update={"group": fitting.name or f"{likely.hfov_deg:.0f}°"})
    return result


def _kind(request: LookupRequest) -> str:
    identity, system = identify(request.camera, request.platform), system_of(request.platform)
    return device_of(identity, system).kind


def _log_tan(calibration: Calibration) -> float:
    """Logarithm of the tangent of half the longer field of view: a pinhole's, else the edge ray's."""
    along_x = calibration.img_size[0] >= calibration.img_size[1]
    focal = axis_focal(calibration)[0 if along_x else 1]
    half = max(calibration.img_size) / 2
    if calibration.distortion_model in _PINHOLES:
        return math.log(half / focal)
    (fx, _, _), (_, fy, _), _ = calibration.camera_matrix
    return math.log(math.tan(_edge_angle(calibration, half / (fx if along_x else fy), along_x=along_x)))


def _edge_angle(calibration: Calibration, target: float, *, along_x: bool) -> float:
    """Angle off the axis, rad, of the ray to `target` on the plane of unit focal length."""
    low, high = 0.0, math.radians(85)
    phi = 0.0 if along_x else math.pi / 2
    for _ in range(40):
        middle = (low + high) / 2
        at = distort_ray(calibration.distortion_model, calibration.distortion_coefficients, middle, phi)
        if at is not None and math.hypot(*at) < target:
            low = middle
        else:
            high = middle
    return high


def _calibration_here(request: LookupRequest, known: Sequence[ConsensusDocument]) -> ConsensusDocument | None:
    """Consensus of this size and zoom, if possible of the requested model."""
    here = [
        c
        for c in known
        if (c.img_size, c.zoom) == (request.img_size, request.zoom) and c.calibration is not None
    ]
    return max(here, key=lambda c: (c.distortion_model == request.distortion_model, c.total), default=None)


def _other_sizes(request: LookupRequest, known: Sequence[ConsensusDocument], kind: str) -> list[Evidence]:
    modes: dict[tuple[tuple[int, int], float], Calibration] = {}
    for c in known:
        mode = c.img_size, c.zoom
        if mode == (request.img_size, request.zoom) or c.calibration is None:
            continue
        if c.reason != "disagree":
            modes.setdefault(mode, c.calibration)
    closest = sorted(modes, key=lambda m: (m[1] != request.zoom, closeness(m[0], request.img_size)))
    return [_elsewhere(modes[mode], request, kind) for mode in closest[:_MAX_OTHER_SIZES]]


def _elsewhere(calibration: Calibration, request: LookupRequest, kind: str) -> Evidence:
    value, size = _log_tan(calibration), calibration.img_size
    evidence = other_size(kind, value, size, request.img_size, calibration.calibrations)
    if calibration.zoom == request.zoom:
        return evidence
    if system_of(request.platform).is_file and request.zoom > 0 and calibration.zoom > 0:
        return evidence.shifted(math.log(calibration.zoom / request.zoom), _FOCAL_SIGMA)
    to_change, to_sigma = zoom_change(request.zoom)
    from_change, from_sigma = zoom_change(calibration.zoom)
    return evidence.shifted(to_change - from_change, math.hypot(to_sigma, from_sigma))


def _reports(request: LookupRequest, kind: str) -> list[Evidence]:
    facts = request.reported
    if facts is None:
        return []
    values = {"f35": facts.focal_35mm, "hfov": facts.hfov_deg, "dfov": facts.dfov_deg}
    return [
        reported(kind, quantity, value, request.img_size)
        for quantity, value in values.items()
        if value is not None
    ]


def _with_lens_of(result: Estimate, calibration: Calibration) -> Estimate:
    (fx, _, cx), (_, fy, cy), last = calibration.camera_matrix
    own = 2 * math.atan(math.exp(_log_tan(calibration)))
    w, h = calibration.img_size
    half = math.tan(math.radians(result.hfov_deg) / 2) * max(1.0, h / w)
    if calibration.distortion_model in _PINHOLES:
        scale = math.tan(own / 2) / half
    else:
        scale = own / (2 * math.atan(half))
    return result.model_copy(
        update={
            "camera_matrix": ((fx * scale, 0.0, cx), (0.0, fy * scale, cy), last),
            "distortion_model": calibration.distortion_model,
            "distortion_coefficients": calibration.distortion_coefficients,
        }
    )
