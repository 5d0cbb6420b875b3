"""Checks: scores a consensus on fresh views of a camera, and counts the result as a vote.

A calibration that the request gives is scored instead, without a vote. The consensus is taken as it is,
reliable or not; only the poses are fitted to the views. A vote keeps the views, so that it can be counted
again for each new consensus (`calibdb.rules.votes`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from starlette.responses import Response

from calibdb.access.tokens import Ticket, contributor, source
from calibdb.camera_key import identify, public_label, public_platform
from calibdb.errors import FieldError, InvalidError, NotFoundError
from calibdb.http import application
from calibdb.lookup import camera_lookup
from calibdb.rules.corners import require_corners
from calibdb.rules.votes import OwnCamera, decide_vote, expected_error, view_digest, vote_id
from calibdb.schema import (
    Calibration,
    CheckAnswer,
    CheckRequest,
    ComparisonAnswer,
    ConsensusDocument,
    FitRecord,
    GivenCalibration,
    RefitRequest,
    ShapeDocument,
    ViewDocument,
    VoteDocument,
)
from calibdb.store import StreamMode
from calibsolver import Board, CalibrationError, Camera, DeadlineError, View, deadline
from calibsolver.capture.admission import rejection_reason
from calibsolver.consensus import difference
from calibsolver.consensus.comparison import compare
from calibsolver.consensus.fit_memory import fit_plausible
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
        The camera fitted to them; None where they say nothing of some part of the image.
    board_shape
        Shape of the board that both refer to; None: as drawn.
    """

    views: tuple[ViewDocument, ...]
    noise: float
    own: FitRecord | None
    board_shape: BoardShape | None


def check(call: application.Call) -> Response:
    """Return whether the consensus fits the views, and what checks say of it, or the comparison asked for."""
    ticket = call.session(charge="views")
    request = call.json(CheckRequest)
    require_corners(request.board, request.img_size, request.views)
    if request.calibration is not None:
        with in_time(call):
            return application.json_response(check_given(request, request.calibration))
    mode, known = consensus(call, request)
    with in_time(call):
        examined = examine(request)
    width = request.img_size[0]
    camera = Camera.from_record(known.model_dump())
    views = Board.from_record(request.board.model_dump()).views([v.model_dump() for v in examined.views])
    if examined.board_shape is not None:
        views = [examined.board_shape.apply(view) for view in views]
    error = min(reprojection_score(camera, views).rms, math.hypot(*request.img_size))
    own = None
    if examined.own is not None:
        by_itself = Camera.from_record(examined.own.model_dump())
        own = OwnCamera(difference(camera, by_itself), examined.own.uncertainty.rms)
    ratio = call.service.settings.thresholds.max_check_ratio
    says = decide_vote(error, examined.noise, width, ratio, own, same_model=True)
    counted = says is not None and vote(call, ticket, request, mode, examined)
    current = refit_now(call, mode, request.distortion_model) if counted else None
    if current is None or current.calibration is None:
        current = consensus_of_model(call.service.store.consensuses.at(mode), request.distortion_model)
    if current is None or current.calibration is None:
        raise NotFoundError("The consensus was withdrawn while this check ran.", kind="no-calibration")
    return application.json_response(
        CheckAnswer(
            fits="does_not_fit" if says is False else "fits",
            error=error,
            expected=expected_error(examined.noise, width),
            counted=counted,
            votes=current.votes,
            calibration=current.calibration,
        )
    )


@contextmanager
def in_time(call: application.Call) -> Iterator[None]:
    """Limit the solver's work in the block to the time that is left; raises InvalidError after it."""
    try:
        with deadline.limit(call.seconds_left):
            yield
    except DeadlineError as late:
        slow = "take longer to compute than a request may; send fewer corners in each"
        raise call.out_of_time(InvalidError.field("views", slow)) from late


def check_given(request: CheckRequest, given: GivenCalibration) -> ComparisonAnswer:
    """Compare a given calibration with a fit of the views; raises InvalidError if either is unusable."""
    if given.img_size != request.img_size:
        raise InvalidError.field("calibration.img_size", "the views have another size")
    try:
        camera = Camera.from_record(given.model_dump())
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


def consensus(call: application.Call, request: CheckRequest) -> tuple[StreamMode, Calibration]:
    """Find the consensus to check, reliable or not, and its mode; raises NotFoundError where there is none.

    It is found as a lookup would find it, but at no other size or zoom than the views'. As in a lookup, what
    a browser cropped is another picture.
    """
    size, zoom, model = request.img_size, request.zoom, request.distortion_model
    private = call.service.settings.thresholds.min_contributors == 1
    identity = identify(request.camera, request.platform)
    if camera_lookup.unanswerable_reason(identity, private=private, resize_mode=request.resize_mode) is None:
        read = call.service.store.cameras.known
        resolved = camera_lookup.resolve(read, identity, size, zoom, model, private=private)
        mode = StreamMode(resolved.key, size, zoom)
        here = [c for c in resolved.known if (c.img_size, c.zoom) == (size, zoom)]
        known = consensus_of_model(here, model) or (refit_now(call, mode, model) if here else None)
        if known is not None and known.calibration is not None:
            return mode, known.calibration
    raise NotFoundError(
        "The database has no consensus to check for this camera at this size; cropped streams have none.",
        kind="no-calibration",
    )


def consensus_of_model(documents: Sequence[ConsensusDocument], model: str) -> ConsensusDocument | None:
    """Return the consensus of this model, None when there is none."""
    return next((d for d in documents if d.distortion_model == model), None)


def refit_now(call: application.Call, mode: StreamMode, model: str) -> ConsensusDocument | None:
    """Have the consensus computed with all that is known by now, and return it."""
    asked = RefitRequest(camera=mode.camera_key, img_size=mode.img_size, zoom=mode.zoom, models=(model,))
    return next(iter(call.service.store.refit.now(asked).models.values()), None)


def examine(request: CheckRequest) -> MeasuredViews:
    """Fit a camera to the views alone; raises InvalidError where there is none that believably took them."""
    views = usable_views(request)
    try:
        own = fit_plausible(views, request.img_size, request.distortion_model)
    except CalibrationError as error:
        raise InvalidError.field("views", error.message) from error
    kept = [
        ViewDocument(
            index=n,
            ids=tuple(i for i, used in zip(view.ids, mask, strict=True) if used),
            points=tuple(p for p, used in zip(view.points, mask, strict=True) if used),
        )
        for n, (view, mask) in enumerate(zip(request.views, own.used, strict=True))
        if mask.sum() >= _MIN_POINTS
    ]
    if not kept:
        raise InvalidError.field("views", "no view can show a board: too few of its corners fit")
    u = own.uncertainty()
    record = FitRecord.model_validate(own.record()) if math.isfinite(u.rms) and math.isfinite(u.max) else None
    return MeasuredViews(tuple(kept), math.sqrt(2) * own.noise, record, own.board_shape)


def usable_views(request: CheckRequest) -> list[View]:
    """Return the views for the solver; raises InvalidError for those that cannot show a board."""
    given = request.model_dump()
    views = Board.from_record(given["board"]).views(given["views"])
    reasons = [rejection_reason(view, request.img_size) for view in views]
    wrong = [
        FieldError(f"views.{n}", _UNFIT.get(reason, reason)) for n, reason in enumerate(reasons) if reason
    ]
    if wrong:
        raise InvalidError(wrong)
    return views


def vote(
    call: application.Call, ticket: Ticket, request: CheckRequest, mode: StreamMode, examined: MeasuredViews
) -> bool:
    """Count the check as a vote, once.

    False where the contributor, by where they are, has none, and for pictures that a calibration was made of:
    they are not independent of it.
    """
    service = call.service
    thresholds = service.settings.thresholds
    secret = service.settings.contributor_secret
    where = source(secret, call.address)
    period = thresholds.contributor_period
    known = service.store.calibrations.newest(mode, thresholds.max_calibrations, period)
    if period and any(calibration.source == where for calibration in known):
        return False
    seen = {view_digest(view.ids, view.points) for view in request.views}
    if any(seen & calibration.views for calibration in known):
        return False
    shape = examined.board_shape
    service.store.votes.cast(
        VoteDocument(
            id=vote_id(request, mode.camera_key, where, ticket.sid, service.now, period),
            camera_key=mode.camera_key,
            camera=public_label(request.camera),
            platform=public_platform(request.platform),
            img_size=mode.img_size,
            zoom=mode.zoom,
            board=request.board,
            views=examined.views,
            noise=examined.noise,
            fit=examined.own,
            board_shape=None if shape is None else ShapeDocument.model_validate(shape.record()),
            contributor=contributor(secret, call.address, ticket.token),
            source=where,
            time=service.now,
            **request.consent,
        )
    )
    # For the other models; this one's is asked for at once.
    service.store.refit.later(RefitRequest(camera=mode.camera_key, img_size=mode.img_size, zoom=mode.zoom))
    return True


handler = application.handler(application.route("/v1/checks", POST=check))
