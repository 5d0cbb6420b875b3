"""Combination of all evidence about one camera at one size."""

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from calibdb.camera_key import identify
from calibdb.camera_key.system import system_of
from calibdb.estimate.angles import Size, horizontal_angle
from calibdb.estimate.crops import zoom_change
from calibdb.estimate.device import Device, device_of
from calibdb.estimate.evidence import Evidence, combine
from calibdb.estimate.knowledge import Knowledge, default_knowledge
from calibdb.estimate.population import QUANTILE, Population
from calibdb.estimate.projection import distort_ray
from calibdb.schema import FitRecord, Uncertainty
from calibdb.schema.estimate import Estimate, EstimateBasis, EstimateInterval

_BASES: tuple[EstimateBasis, ...] = (
    *("calibrations", "views", "device", "other_size", "published", "family", "population"),
)
_ZEROS = {"rectilinear": 5, "rational": 8, "fisheye": 4}  # coefficients of a lens without distortion
_PRIOR_WIDENING = 2.0
_CROPPED_SIGMA = 0.25


@dataclass(frozen=True)
class EstimateQuery:
    """Camera and size to estimate."""

    camera: str
    platform: str
    img_size: tuple[int, int]
    zoom: float = 0.0
    cropped: bool = False  # by the browser
    evidence: tuple[Evidence, ...] = ()
    """Of this camera, size and zoom."""


@dataclass(frozen=True)
class Distribution:
    """Distribution of `log_tan` along the longer side, with a 90 % interval."""

    centre: float
    low: float
    high: float
    best: Evidence


def combine_evidence(
    knowledge: Knowledge,
    device: Device,
    size: Size,
    stated: Sequence[Evidence],
    change: float = 0.0,
    sigma: float = 0.0,
) -> Distribution:
    """Combine statements about one camera with the distribution of its family, else of its kind.

    `change`, `sigma`: of `log_tan` by zoom and crop, which `stated` includes.
    """
    family = knowledge.family(device, size)
    group = family or knowledge.population(device, size)
    prior = Evidence("family" if family else "population", group.median, group.sigma).shifted(change, sigma)
    if not stated:
        return _prior_only(prior, group, sigma)
    # Published values are a distribution of the model's units. Without them the family is a weak prior, so
    # that one wrong statement widens the interval.
    if not any(e.basis == "published" for e in stated):
        stated = [*stated, replace(prior, sigma=_PRIOR_WIDENING * prior.sigma)]
    mean, total = combine(stated)
    best = min(stated, key=lambda e: _BASES.index(e.basis))
    return Distribution(mean, mean - QUANTILE * total, mean + QUANTILE * total, best)


def _prior_only(prior: Evidence, population: Population, sigma: float) -> Distribution:
    below, above = population.median - population.low, population.high - population.median
    reach = QUANTILE * sigma
    return Distribution(
        prior.mean, prior.mean - math.hypot(below, reach), prior.mean + math.hypot(above, reach), prior
    )


@functools.lru_cache(maxsize=256)
def estimate(query: EstimateQuery) -> Estimate:
    """Estimate a camera."""
    knowledge, system = default_knowledge(), system_of(query.platform)
    device = device_of(identify(query.camera, query.platform), system)
    # The zoom of a photograph is its focal length, mm, to which published values refer.
    change, sigma = (0.0, 0.0) if system.is_file else zoom_change(query.zoom)
    if query.cropped:
        sigma = math.hypot(sigma, _CROPPED_SIGMA)
    stated = list(query.evidence)
    if (public := knowledge.published(device, query.img_size)) is not None:
        stated.append(public.shifted(change, sigma))
    result = combine_evidence(knowledge, device, query.img_size, stated, change, sigma)
    w, h = query.img_size
    best = result.best
    half_long = max(w, h) / 2
    angle = horizontal_angle(result.centre)
    half_angle = math.radians(angle) / 2
    edge = distort_ray("fisheye", best.lens, half_angle, 0.0) if best.lens else None
    lens = () if edge is None else best.lens
    focal = half_long / (math.tan(half_angle) if edge is None else edge[0])
    hfov, low, high = (
        _angle_of_width(w, h, horizontal_angle(value)) for value in (result.centre, result.low, result.high)
    )
    return Estimate(
        img_size=query.img_size,
        camera_matrix=((focal, 0.0, (w - 1) / 2), (0.0, focal, (h - 1) / 2), (0.0, 0.0, 1.0)),
        distortion_model="fisheye" if lens else "rectilinear",
        distortion_coefficients=lens or (0.0,) * 5,
        hfov_deg=round(hfov, 2),
        interval_90=EstimateInterval(hfov_deg=(round(low, 2), round(high, 2))),
        basis=best.basis,
        sources=best.sources,
    )


def _angle_of_width(w: int, h: int, angle: float) -> float:
    """Horizontal angle of a picture whose longer side spans `angle`, degrees."""
    if w >= h:
        return angle
    return 2 * math.degrees(math.atan(math.tan(math.radians(angle) / 2) * w / h))


def starting_camera(query: EstimateQuery, model: str) -> FitRecord | None:
    """Estimate as the initial camera of a capture; None for an omnidirectional one."""
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
