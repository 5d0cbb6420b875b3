"""Checks of a consensus, or of a given calibration, on fresh views."""

import math
from contextlib import AbstractContextManager

from calibdb.compute.pooled_consensus import MeasuredViews
from calibdb.compute.values import board_of, camera_of, in_time, naming, views_of
from calibdb.errors import FieldError, InvalidError
from calibdb.http.call import Call
from calibdb.schema import (
    CheckRequest,
    ComparisonAnswer,
    FitRecord,
    GivenCalibration,
    ShapeDocument,
    ViewDocument,
)
from calibsolver import View, fit
from calibsolver.capture.admission import rejection_reason
from calibsolver.consensus.comparison import compare

_MIN_POINTS = 4  # for a pose
_UNFIT = {
    "too_few_points": "too few corners to tell how the board is held",
    "degenerate": "the corners lie on a line, or nearly",
    "mirrored": "the picture is mirrored",
}


def computing_check(call: Call) -> AbstractContextManager[None]:
    """Limit the time; raises InvalidError or UnavailableError."""
    slow = "take longer to compute than a request may; send fewer corners in each"
    return in_time(call, InvalidError.field("views", slow))


def check_given(request: CheckRequest, given: GivenCalibration) -> ComparisonAnswer:
    """Compare a calibration with a fit of the views; raises InvalidError."""
    if given.img_size != request.img_size:
        raise InvalidError.field("calibration.img_size", "the views have another size")
    with naming("calibration"):
        camera = camera_of(given)
    if min(camera.focal) <= 0:
        raise InvalidError.field("calibration.camera_matrix", "the focal lengths must be positive")
    with naming("views"):
        result = compare(camera, _usable_views(request))
    return ComparisonAnswer(
        fits="fits" if result.fits else "does_not_fit",
        error=_finite(result.error),
        expected=result.expected,
        drift=_finite(result.drift),
        drift_uncertainty=_finite(result.drift_uncertainty),
        views=result.views,
    )


def _finite(px: float) -> float | None:
    return px if math.isfinite(px) else None


def examine(request: CheckRequest) -> MeasuredViews:
    """Fit a camera to the views only; raises InvalidError."""
    views = _usable_views(request)
    with naming("views"):
        own = fit(views, request.img_size, request.distortion_model)
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


def _usable_views(request: CheckRequest) -> list[View]:
    views = views_of(board_of(request.board), request.views)
    reasons = [rejection_reason(view, request.img_size) for view in views]
    wrong = [
        FieldError(f"views.{n}", _UNFIT.get(reason, reason)) for n, reason in enumerate(reasons) if reason
    ]
    if wrong:
        raise InvalidError(wrong)
    return views
