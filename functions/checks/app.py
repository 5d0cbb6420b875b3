"""Checks: scores a consensus on fresh views of a camera, and counts the result as a vote."""

from starlette.responses import Response

from calibdb.access.tokens import Ticket
from calibdb.camera_key import public_label, public_platform
from calibdb.compute import view_checks
from calibdb.compute.pooled_consensus import MeasuredViews, score
from calibdb.compute.view_checks import computing_check
from calibdb.errors import NotFoundError
from calibdb.http import application
from calibdb.http.application import Call, json_response, route
from calibdb.lookup.camera_match import consensus_of_model, find_checked
from calibdb.rules.session_rules import require_corners
from calibdb.rules.votes import view_digest, vote_id
from calibdb.schema import CheckAnswer, CheckRequest, RefitRequest, VoteDocument
from calibdb.store import StreamMode


def check(call: Call) -> Response:
    """Check a consensus or a given calibration."""
    ticket = call.session(charge="views")
    request = call.json(CheckRequest)
    require_corners(request.board, request.img_size, request.views)
    if request.calibration is not None:
        with computing_check(call):
            return json_response(view_checks.check_given(request, request.calibration))
    store, thresholds = call.store, call.service.settings.thresholds
    mode, known = find_checked(store, request, private=thresholds.min_contributors == 1)
    with computing_check(call):
        examined = view_checks.examine(request)
    scored = score(request.board, examined, known, thresholds.max_check_ratio)
    counted = scored.fits is not None and vote(call, ticket, request, mode, examined)
    current = store.refit.consensus(mode, request.distortion_model) if counted else None
    if current is None or current.calibration is None:
        current = consensus_of_model(store.consensuses.at(mode), request.distortion_model)
    if current is None or current.calibration is None:
        raise NotFoundError("The consensus was withdrawn while this check ran.", kind="no-calibration")
    return json_response(
        CheckAnswer(
            fits="does_not_fit" if scored.fits is False else "fits",
            error=scored.error,
            expected=scored.expected,
            counted=counted,
            votes=current.votes,
            calibration=current.calibration,
        )
    )


def vote(
    call: Call, ticket: Ticket, request: CheckRequest, mode: StreamMode, examined: MeasuredViews
) -> bool:
    """Count a check as a vote, once.

    False if its contributor has none, or if a calibration was made of its images.
    """
    service = call.service
    thresholds = service.settings.thresholds
    where = service.source(call.address)
    period = thresholds.contributor_period
    known = service.store.calibrations.newest(mode, thresholds.max_calibrations, period)
    if period and any(calibration.source == where for calibration in known):
        return False
    seen = {view_digest(view.ids, view.points) for view in request.views}
    if any(seen & calibration.views for calibration in known):
        return False
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
            board_shape=examined.board_shape,
            contributor=service.contributor(call.address, ticket.token),
            source=where,
            time=service.now,
            **request.consent,
        )
    )
    # For the other models.
    service.store.refit.later(RefitRequest(camera=mode.camera_key, img_size=mode.img_size, zoom=mode.zoom))
    return True


handler = application.handler(route("/v1/checks", POST=check))
