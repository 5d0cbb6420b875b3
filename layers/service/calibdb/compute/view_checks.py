"""Checks of a camera on fresh views: of a consensus, or of a calibration that the request gives."""

from __future__ import annotations

import math
from contextlib import AbstractContextManager
from dataclasses import dataclass

from calibdb.compute.values import board_of, camera_of, in_time, views_of
from calibdb.errors import FieldError, InvalidError
from calibdb.http.call import Call
from calibdb.rules.votes import OwnCamera, decide_vote, expected_error
from calibdb.schema import (
    Calibration,
    CheckRequest,
    ComparisonAnswer,
    FitRecord,
    GivenCalibration,
    ShapeDocument,
    ViewDocument,
)
from calibsolver import CalibrationError, View, fit
from calibsolver.capture.admission import rejection_reason
from calibsolver.consensus import difference
from calibsolver.consensus.comparison import compare
from calibsolver.fitting.board_shape import BoardShape
from calibsolver.fitting.resection import reprojection_score

_MIN_POINTS = 4  # for a pose
_UNFIT = {
    "too_few_points": "too few corners to tell how the board is held",
    "degenerate": "the corners lie on a line, or nearly",
    "mirrored": "the picture is mirrored",
}


@dataclass(frozen=True)
class MeasuredViews:
    """Fresh views, measured without the consensus.

    Attributes
    ----------
    views
        By view ids (n,) and points (n, 2) px, without those that no camera explains: misread corners.
    noise
        px rms of these under a camera fitted to them.
    own
        The camera fitted to them; None if they say nothing of some part of the image.
    board_shape
        Shape of the board that both refer to; None: as drawn.
    """

    views: tuple[ViewDocument, ...]
    noise: float
    own: FitRecord | None
    board_shape: ShapeDocument | None


@dataclass(frozen=True)
class Score:
    """Score of a consensus on views; `fits`: None if they are too noisy to say."""

    fits: bool | None
    error: float  # px
    expected: float  # px


def computing_check(call: Call) -> AbstractContextManager[None]:
    """Compute in the time of the call; raises InvalidError or UnavailableError if that is too short."""
    slow = "take longer to compute than a request may; send fewer corners in each"
    return in_time(call, InvalidError.field("views", slow))


def score(request: CheckRequest, examined: MeasuredViews, consensus: Calibration, max_ratio: float) -> Score:
    """Score a consensus on views; only the poses are fitted to them."""
    camera, width = camera_of(consensus), request.img_size[0]
    views = views_of(board_of(request.board), examined.views)
    if examined.board_shape is not None:
        shape = BoardShape.from_record(examined.board_shape.model_dump())
        views = [shape.apply(view) for view in views]
    error = min(reprojection_score(camera, views).rms, math.hypot(*request.img_size))
    own = None
    if examined.own is not None:
        own = OwnCamera(difference(camera, camera_of(examined.own)), examined.own.uncertainty.rms)
    says = decide_vote(error, examined.noise, width, max_ratio, own, same_model=True)
    return Score(says, error, expected_error(examined.noise, width))


def check_given(request: CheckRequest, given: GivenCalibration) -> ComparisonAnswer:
    """Compare a given calibration with a fit of the views; raises InvalidError if either is unusable."""
    if given.img_size != request.img_size:
        raise InvalidError.field("calibration.img_size", "the views have another size")
    try:
        camera = camera_of(given)
    except CalibrationError as error:
        raise InvalidError.field("calibration", error.message) from error
    if min(camera.focal) <= 0:
        raise InvalidError.field("calibration.camera_matrix", "the focal lengths must be positive")
    try:
        result = compare(camera, usable_views(request))
    except CalibrationError as error:
        raise InvalidError.field("views", error.message) from error
    finite = (
        px if math.isfinite(px) else None for px in (result.error, result.drift, result.drift_uncertainty)
    )
    rms, drift, uncertainty = finite
    return ComparisonAnswer(
        fits="fits" if result.fits else "does_not_fit",
        error=rms,
        expected=result.expected,
        drift=drift,
        drift_uncertainty=uncertainty,
        views=result.views,
    )


def examine(request: CheckRequest) -> MeasuredViews:
    """Fit a camera to the views alone; raises InvalidError if there is none that believably took them."""
    views = usable_views(request)
    try:
        own = fit(views, request.img_size, request.distortion_model)
    except CalibrationError as error:
        raise InvalidError.field("views", error.message) from error
    usable = [
        ViewDocument(
            index=n,
            ids=tuple(i for i, used in zip(view.ids, mask, strict=True) if used),
            points=tuple(p for p, used in zip(view.points, mask, strict=True) if used),
        )
        for n, (view, mask) in enumerate(zip(request.views, own.used, strict=True))
        if mask.sum() >= _MIN_POINTS
    ]
    if not usable:
        raise InvalidError.field("views", "no view can show a board: too few of its corners fit")
    u = own.uncertainty()
    record = FitRecord.model_validate(own.record()) if math.isfinite(u.rms) and math.isfinite(u.max) else None
    shape = None if own.board_shape is None else ShapeDocument.model_validate(own.board_shape.record())
    return MeasuredViews(tuple(usable), math.sqrt(2) * own.noise, record, shape)


def usable_views(request: CheckRequest) -> list[View]:
    """Return the views for the solver; raises InvalidError for those that cannot show a board."""
    views = views_of(board_of(request.board), request.views)
    reasons = [rejection_reason(view, request.img_size) for view in views]
    wrong = [
        FieldError(f"views.{n}", _UNFIT.get(reason, reason)) for n, reason in enumerate(reasons) if reason
    ]
    if wrong:
        raise InvalidError(wrong)
    return views
