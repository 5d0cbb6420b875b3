"""Answers to lookups: a stored calibration, and its transfer to the size or zoom that was asked for."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from calibdb.lookup.projection import axis_focal, is_projectable
from calibdb.lookup.relation import Window, relate, scaling_window, transfer_intrinsics
from calibdb.lookup.selection import closeness, same_aspect
from calibdb.schema import Adapted, Calibration, ConsensusDocument, LookupAnswer, Uncertainty
from calibdb.schema.calibration import Relation

_MIN_EVIDENCE = 2  # calibrations at a size that is not reliable yet, so that they may verify a relation
_MAX_FOCAL_RATIO = 2.0  # of the focal lengths at two zooms, up to which a lens is interpolated between them


def build_answer(
    found: Calibration, consensuses: Sequence[ConsensusDocument], img_size: tuple[int, int]
) -> LookupAnswer:
    """Answer with `found`, its relation to the size asked for, and its intrinsics there if that is verified.

    `consensuses`: all consensuses of the camera.
    """
    at = {
        c.img_size: c
        for c in consensuses
        if (c.zoom, c.distortion_model) == (found.zoom, found.distortion_model) and c.calibration
    }
    relation, adapted = _relate_and_adapt(found, at, img_size)
    exact = found.img_size == img_size
    return LookupAnswer(**{**dict(found), "exact_size": exact}, relation=relation, adapted=adapted)


def interpolate_zoom(lower: Calibration, upper: Calibration, zoom: float) -> LookupAnswer:
    """Interpolate two calibrations of one size linearly to `zoom`, as certain as the less certain of them."""
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
            inside=_max_or_none(lower.uncertainty.inside, upper.uncertainty.inside),
            covered=_min_or_none(lower.uncertainty.covered, upper.uncertainty.covered),
        ),
        "spread": _max_or_none(lower.spread, upper.spread),
        "held_out_error": _max_or_none(lower.held_out_error, upper.held_out_error),
        "systematic": _max_or_none(lower.systematic, upper.systematic),
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
    """Find the reliable calibrations at the next zooms below and above; None if they do not interpolate.

    Between two zooms a lens is taken to change evenly only if it does so over all calibrated ones: the
    focal lengths grow with the zoom, and do not double from one to the next. Calibrations that disagree at
    this very zoom say that it is not what lies between. And 0 is what a browser says that knows no zoom: it
    may be any.
    """
    if any((c.img_size, c.zoom, c.reason) == (img_size, zoom, "disagree") for c in consensuses):
        return None
    here = sorted(
        (
            c.calibration
            for c in consensuses
            if c.calibration
            and is_projectable(c.calibration)
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


def _focal_ratios(one: Calibration, other: Calibration) -> tuple[float, float]:
    """Return by how much the focal lengths at the axis grow from `one` to `other`, along x and y."""
    fx, fy = axis_focal(one)
    other_fx, other_fy = axis_focal(other)
    return other_fx / fx, other_fy / fy


def _relate_and_adapt(
    found: Calibration, at: dict[tuple[int, int], ConsensusDocument], requested: tuple[int, int]
) -> tuple[Relation | None, Adapted | None]:
    here = at.get(requested)
    if here is not None and found.img_size != requested:
        # Too few to be relied on, but enough to say which of the pictures it can be this one is.
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
        # Of a size that was never calibrated only this can be said: between two sizes that show the same
        # it also shows the same. Beyond them many a camera begins to cut.
        alike = sorted(
            (c for c in (found, *others) if same_aspect(c.img_size, requested)), key=lambda c: c.img_size[0]
        )
        lower = [c for c in alike if c.img_size[0] < requested[0]]
        upper = [c for c in alike if c.img_size[0] > requested[0]]
        if lower and upper and found in alike and relate(lower[-1], upper[0])[0] == "scale":
            window = scaling_window(found, requested)
            return "scale", _adapted_to(found, window, requested)
    closest = min(others, key=lambda c: closeness(c.img_size, found.img_size))
    return relate(found, closest)[0], None


def _adapted_to(calibration: Calibration, window: Window, img_size: tuple[int, int]) -> Adapted:
    matrix, distortion = transfer_intrinsics(calibration, window)
    return Adapted(
        img_size=img_size, zoom=calibration.zoom, camera_matrix=matrix, distortion_coefficients=distortion
    )


def _max_or_none(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else max(one, other)


def _min_or_none(one: float | None, other: float | None) -> float | None:
    return None if one is None or other is None else min(one, other)
