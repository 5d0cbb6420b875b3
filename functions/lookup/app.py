"""Lookup: the calibration of the camera that a page just opened, or the way to one.

A hit is one Query and no write. A hit by POST makes `refit` store its label and platform as an alias, by
which `GET /known/v1/<digest>/…` finds the camera.
"""

import functools

from starlette.responses import Response

from calibdb.errors import NotFoundError
from calibdb.http import application, metrics
from calibdb.http.application import Call, json_response, route, tagged_response
from calibdb.lookup import reports
from calibdb.lookup.camera_match import LookupResult, find, find_by_digest
from calibdb.lookup.estimation import estimate_for
from calibdb.rules.session_rules import require_corners
from calibdb.schema.documents import ConsensusDocument
from calibdb.schema.lookup import LookupRequest, Miss, NoCalibration, UnknownCamera
from calibdb.schema.refit import FittingGroup, RefitRequest
from calibdb.store import StreamMode

_CACHED = {"Cache-Control": "public, max-age=20", "Vary": "Authorization, Origin"}

# A withdrawn camera is gone from browsers and the edge in six minutes.
_KNOWN_CACHE = "public, max-age=60, s-maxage=300, stale-while-revalidate=60, stale-if-error=86400"
_KNOWN = {"Cache-Control": _KNOWN_CACHE, "Access-Control-Allow-Origin": "*"}
_UNKNOWN = {"Cache-Control": "public, max-age=60, s-maxage=60", "Access-Control-Allow-Origin": "*"}


def ask(call: Call) -> Response:
    """Answer a request in a body, in which an older client also sends its token."""
    call.api_token(call.json_text("api_key"))
    return _answer(call, call.json(LookupRequest))


def visit(call: Call) -> Response:
    """Answer a request in a query; `key` has the token of navigations."""
    query = call.request.query_params
    call.api_token(query.get("key") or query.get("api_key"))
    return _answer(call, call.query(LookupRequest))


def _answer(call: Call, request: LookupRequest) -> Response:
    if request.views:
        require_corners(request.board, request.img_size, request.views)
    found = _find(call, request)
    answer = found.answer
    if answer is not None:
        metrics.count(Lookups=1)
        if request.estimate == "always":
            answer = answer.model_copy(update={"estimate": estimate_for(request, ())})
        return json_response(answer, 200, _CACHED if call.request.method != "POST" else None)
    url = call.service.settings.guidance_url + "?" + request.key_query
    likely = estimate_for(request, found.known, _group(call, request, found))
    miss = Miss(guidance_url=url, reason=found.reason, detail=found.detail, estimate=likely)
    metrics.count(Lookups=1, Misses=1)
    if request.miss == "ok":
        return json_response(NoCalibration(**dict(miss)))
    if request.redirect and call.flag("redirect", default=True):
        metrics.count(Redirects=1)
        return json_response(miss, 307, {"Location": url})
    facts = miss.model_dump(mode="json", include={"guidance_url", "reason", "estimate"})
    raise NotFoundError(found.detail, kind="no-calibration", extensions=facts)


def _find(call: Call, request: LookupRequest) -> LookupResult:
    service = call.service
    store, least = service.store, service.settings.thresholds.min_contributors
    read = functools.cache(store.cameras.known)

    def compute(key: str, size: tuple[int, int]) -> ConsensusDocument | None:
        call.require_thread()
        return store.refit.consensus(StreamMode(key, size, request.zoom), request.distortion_model)

    found = find(read, request, private=least == 1, compute=compute)
    report = None
    if found.answer is None:
        report = reports.miss_report(service.misses, request, read, found, service.clock(), least)
    elif call.request.method == "POST":
        sender = functools.partial(service.source, call.address)
        report = reports.alias_report(service.aliases, store, request, found.key, service.clock(), sender)
    if report is not None:
        service.write_later(functools.partial(store.refit.report, report))  # no response depends on it
    return found


def _group(call: Call, request: LookupRequest, found: LookupResult) -> FittingGroup | None:
    """Group of disagreeing calibrations that fits the views sent."""
    if not request.views or found.reason != "disagree" or not found.key:
        return None
    call.require_thread()
    return call.store.refit.now(RefitRequest.of_views(found.key, request)).fitting


def known(call: Call) -> Response:
    """Answer a lookup by the digest of label and platform."""
    address = "/".join(call.path(name) for name in ("size", "zoom", "file"))
    private = call.service.settings.thresholds.min_contributors == 1
    found = find_by_digest(call.store, call.path("digest"), address, private=private)
    if found is None:
        return json_response(UnknownCamera(reason="unknown_camera"), 404, _UNKNOWN)
    metrics.count(Lookups=1)
    if found.answer is None:
        return json_response(UnknownCamera(reason=found.reason), 404, _UNKNOWN)
    return tagged_response(call.request, found.answer, _KNOWN)


handler = application.handler(
    route("/v1/lookup", is_quick=True, POST=ask, GET=visit),
    route("/known/v1/{digest}/{size}/{zoom}/{file}", is_quick=True, GET=known),
)
