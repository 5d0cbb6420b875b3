"""Lookup: the calibration of the camera that a page just opened, or the way to one.

A lookup that hits is one Query. No lookup writes for itself: tokens are read twice a minute, and lookups are
counted in memory and flushed in batches (`calibdb.access.token_cache`).
"""

from __future__ import annotations

from urllib.parse import urlencode

from starlette.responses import Response

from calibdb.camera_key import identify
from calibdb.errors import NotFoundError
from calibdb.http import application, metrics
from calibdb.lookup import camera_lookup
from calibdb.lookup.answer import bracketing_zooms, build_answer, interpolate_zoom
from calibdb.schema import LookupAnswer, LookupRequest, Miss, RefitRequest
from calibdb.schema.fields import size_text, zoom_text

# By browsers, and at the edge for the same token from the same origin; both may be refused.
_PUBLIC_CACHE = {"Cache-Control": "public, max-age=20", "Vary": "Authorization, Origin"}
_NOTHING = "The database has no reliable calibration of this camera."
_DETAILS = {
    "unknown_camera": _NOTHING,
    "too_few": "The database has too few calibrations of this camera.",
    "disagree": "The calibrations of this camera disagree.",
    "few_contributors": "The calibrations of this camera come from too few contributors.",
}


def ask(call: application.Call) -> Response:
    """Answer a request in a body. The older public client sends its token there, too."""
    call.api_token(call.json_text("api_key"))
    return _answer(call, call.json(LookupRequest))


def visit(call: application.Call) -> Response:
    """Answer a request in a query; with the token in `key`, a browser can navigate to it."""
    query = call.request.query_params
    call.api_token(query.get("key") or query.get("api_key"))
    return _answer(call, call.query(LookupRequest))


def _answer(call: application.Call, request: LookupRequest) -> Response:
    found = _find(call, request)
    now = call.service.clock()
    if isinstance(found, LookupAnswer):
        metrics.count(now, Lookups=1, Hits=1)
        return application.json_response(
            found, headers=_PUBLIC_CACHE if call.request.method != "POST" else None
        )
    if not (request.redirect and call.flag("redirect", default=True)):
        metrics.count(now, Lookups=1, Misses=1)
        raise NotFoundError(
            found.detail,
            kind="no-calibration",
            extensions={"guidance_url": found.guidance_url, "reason": found.reason},
        )
    metrics.count(now, Lookups=1, Misses=1, Redirects=1)
    return application.json_response(found, 307, {"Location": found.guidance_url})


def _find(call: application.Call, request: LookupRequest) -> LookupAnswer | Miss:
    url = call.service.settings.guidance_url + "?" + urlencode(_key(request))
    private = call.service.settings.thresholds.min_contributors == 1
    identity = identify(request.camera, request.platform)
    why = camera_lookup.unanswerable_reason(identity, private=private, resize_mode=request.resize_mode)
    if why is not None:
        return Miss(guidance_url=url, reason="unknown_camera", detail=why)
    store, size, zoom, model = call.service.store, request.img_size, request.zoom, request.distortion_model
    resolved = camera_lookup.resolve(store.cameras.known, identity, size, zoom, model, private=private)
    found, reason = resolved.choice.found, resolved.choice.reason
    if resolved.choice.missing_at is not None:
        # The keypoints are kept, so a model that nobody asked for yet is only a computation away.
        missing = resolved.choice.missing_at
        refit = RefitRequest(camera=resolved.key, img_size=missing, zoom=zoom, models=(model,))
        found = store.refit.now(refit).models.get(model)
        reason = found.reason if found and found.reason else reason
    if found is not None and found.reliable and found.calibration is not None:
        return build_answer(found.calibration, resolved.known, size)
    around = bracketing_zooms(resolved.known, size, zoom, model)
    if around is not None:
        return interpolate_zoom(*around, zoom)
    detail = camera_lookup.SEVERAL if resolved.several else _DETAILS[reason]
    return Miss(guidance_url=url, reason=reason, detail=detail)


def _key(request: LookupRequest) -> dict[str, str]:
    return {
        "camera": request.camera,
        "platform": request.platform,
        "img_size": size_text(request.img_size),
        "zoom": zoom_text(request.zoom),
        "distortion_model": request.distortion_model,
    }


handler = application.handler(application.route("/v1/lookup", POST=ask, GET=visit))
