"""The calibration of the camera that a page just opened, or the way to one.

A lookup that hits is one Query, and nothing is ever written.
"""

from __future__ import annotations

from urllib.parse import urlencode

from starlette.responses import Response

from calibdb import http
from calibdb.camera_key import camera_key
from calibdb.errors import NotFoundError
from calibdb.schema import Calibration, LookupRequest, Miss, RefitRequest
from calibdb.schema.lookup import Reason
from calibdb.selection import choose
from calibdb.store.keys import size_text, zoom_text

_CACHED = {"Cache-Control": "private, max-age=60", "Vary": "Authorization"}


def ask(call: http.Call) -> Response:
    """Answer a request in a body. The older public client sends its token there, too."""
    call.api_token(call.json_text("api_key"))
    return _answer(call, call.json(LookupRequest))


def visit(call: http.Call) -> Response:
    """Answer a request in a query; with the token in `key`, a browser can navigate to it."""
    query = call.request.query_params
    call.api_token(query.get("key") or query.get("api_key"))
    return _answer(call, call.query(LookupRequest))


def _answer(call: http.Call, request: LookupRequest) -> Response:
    found, reason = _find(call, request)
    if found is not None:
        exact = found.model_copy(update={"exact_size": found.img_size == request.img_size})
        return http.answer(exact, headers=_CACHED if call.request.method != "POST" else None)
    url = call.service.settings.guidance_url + "?" + urlencode(_key(request))
    if not (request.redirect and call.flag("redirect", default=True)):
        raise NotFoundError(
            "Nothing reliable is known of this camera.",
            kind="no-calibration",
            members={"guidance_url": url, "reason": reason},
        )
    return http.answer(Miss(guidance_url=url, reason=reason), 307, {"Location": url})


def _find(call: http.Call, request: LookupRequest) -> tuple[Calibration | None, Reason]:
    key = camera_key(request.camera, request.platform)
    store = call.service.store
    choice = choose(store.consensuses.of(key), request.img_size, request.zoom, request.distortion_model)
    found = choice.found
    if choice.missing_at is not None:
        # The keypoints are kept, so a model that nobody asked for yet is only a computation away.
        model = request.distortion_model
        refit = RefitRequest(camera=key, img_size=choice.missing_at, zoom=request.zoom, models=(model,))
        found = store.refit.now(refit).models.get(model)
    if found is None:
        return None, choice.reason
    return found.calibration if found.reliable else None, found.reason or choice.reason


def _key(request: LookupRequest) -> dict[str, str]:
    return {
        "camera": request.camera,
        "platform": request.platform,
        "img_size": size_text(request.img_size),
        "zoom": zoom_text(request.zoom),
        "distortion_model": request.distortion_model,
    }


handler = http.handler(http.resource("/v1/lookup", POST=ask, GET=visit))
