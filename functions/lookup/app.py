"""Lookup: the calibration of the camera that a page just opened, or the way to one.

A lookup that hits is one Query. No lookup writes for itself: tokens are read twice a minute, and lookups are
counted in memory and flushed in batches (`calibdb.access.token_cache`). A hit by POST under a label and
platform that are new is reported to `refit`, which stores them as an alias. From then on the camera is also
found by `GET /known/v1/<digest>/…`, which has no credential, and which caches keep.
"""

from __future__ import annotations

import functools
import hashlib
import logging
import re
from collections.abc import Callable
from dataclasses import replace
from urllib.parse import urlencode

from starlette.responses import Response

from calibdb.access.tokens import source
from calibdb.camera_key import identify, public_label, public_platform
from calibdb.errors import NotFoundError, UnavailableError
from calibdb.http import application, metrics
from calibdb.lookup.calibration_lookup import LookupQuery, LookupResult, find
from calibdb.lookup.camera_search import is_listed
from calibdb.lookup.estimation import estimate_for
from calibdb.rules.corners import require_corners
from calibdb.schema import (
    DISTORTION_MODELS,
    ConsensusDocument,
    FittingGroup,
    LookupRequest,
    Miss,
    ModeViews,
    NewAlias,
    NoCalibration,
    RefitRequest,
    UnknownCamera,
    ViewDocument,
)
from calibdb.schema.fields import size_text, zoom_text
from calibdb.schema.lookup import Reason
from calibdb.service import Service
from calibdb.store import CameraRecords
from calibdb.store.aliases import alias_digest
from calibdb.store.miss_counts import USB

# By browsers, and at the edge for the same token from the same origin; both may be refused.
_PUBLIC_CACHE = {"Cache-Control": "public, max-age=20", "Vary": "Authorization, Origin"}

# Browsers keep an answer for a minute, the edge for five: a withdrawn camera is gone from both in six.
_KNOWN_CACHE = "public, max-age=60, s-maxage=300, stale-while-revalidate=60, stale-if-error=86400"
_UNKNOWN_CACHE = "public, max-age=60, s-maxage=60"
_DIGEST = re.compile("[0-9a-f]{32}")
_SIZE = re.compile("([1-9][0-9]{0,4})x([1-9][0-9]{0,4})")
_ZOOM = re.compile(r"[0-9]{1,7}(\.[0-9]{1,6})?")

_log = logging.getLogger(__name__)


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
    require_corners(request.board, request.img_size, request.views)
    found = _find(call, request)
    now = call.service.clock()
    if found.answer is not None:
        metrics.count(now, Lookups=1)
        return application.json_response(
            found.answer, headers=_PUBLIC_CACHE if call.request.method != "POST" else None
        )
    url = call.service.settings.guidance_url + "?" + urlencode(_key(request))
    likely = estimate_for(request, found.known, _fitting_group(call, request, found))
    if request.miss == "ok":
        metrics.count(now, Lookups=1, Misses=1)
        return application.json_response(
            NoCalibration(reason=found.reason, guidance_url=url, detail=found.detail, estimate=likely)
        )
    if not (request.redirect and call.flag("redirect", default=True)):
        metrics.count(now, Lookups=1, Misses=1)
        raise NotFoundError(
            found.detail,
            kind="no-calibration",
            extensions={
                "guidance_url": url,
                "reason": found.reason,
                "estimate": likely.model_dump(mode="json"),
            },
        )
    metrics.count(now, Lookups=1, Misses=1, Redirects=1)
    miss = Miss(guidance_url=url, reason=found.reason, detail=found.detail, estimate=likely)
    return application.json_response(miss, 307, {"Location": url})


def _find(call: application.Call, request: LookupRequest) -> LookupResult:
    store, size, zoom, model = call.service.store, request.img_size, request.zoom, request.distortion_model
    read = functools.cache(store.cameras.known)

    def compute(key: str, size: tuple[int, int]) -> ConsensusDocument | None:
        call.require_thread()
        refit = RefitRequest(camera=key, img_size=size, zoom=zoom, models=(model,))
        return store.refit.now(refit).models.get(model)

    wanted = LookupQuery(request.camera, request.platform, size, zoom, model, request.resize_mode)
    private = call.service.settings.thresholds.min_contributors == 1
    found = find(read, wanted, private=private, compute=compute)
    if found.answer is not None and call.request.method == "POST":
        _report(call, request, found)
    elif found.answer is None and found.key:
        _count_miss(call, request, read, found)
    return found


def _fitting_group(
    call: application.Call, request: LookupRequest, found: LookupResult
) -> FittingGroup | None:
    """Return the group of the camera's calibrations that fits the views sent, if they fall into groups."""
    if not request.views or found.reason != "disagree" or not found.key:
        return None
    call.require_thread()
    views = (ViewDocument(index=n, ids=v.ids, points=v.points) for n, v in enumerate(request.views))
    seen = ModeViews(board=request.board.model_dump(mode="json"), views=tuple(views))
    asked = RefitRequest(
        camera=found.key,
        img_size=request.img_size,
        zoom=request.zoom,
        models=(request.distortion_model,),
        seen=seen,
    )
    return call.service.store.refit.now(asked).fitting


def _count_miss(
    call: application.Call, request: LookupRequest, read: Callable[[str], CameraRecords], found: LookupResult
) -> None:
    """Count that a camera was asked for that is not known; now and then, have the counts written down.

    By its key only where others have calibrated it: a key has parts of a label, which is whatever its sender
    wrote. Else by its USB id.
    """
    service, known = call.service, read(found.key).consensuses
    usb_id = identify(request.camera, request.platform).usb_id
    if known and is_listed(known, max(2, service.settings.thresholds.min_contributors)):
        camera = found.key
    elif usb_id is not None:
        camera = USB + usb_id
    else:
        return
    counted = service.misses.count(camera, service.clock())
    if not counted:
        return
    _queue(service, RefitRequest(camera=found.key, img_size=request.img_size, misses=counted))


def _report(call: application.Call, request: LookupRequest, found: LookupResult) -> None:
    """Have an alias that is new stored; the answer does not wait for that."""
    service, name = call.service, (request.camera, request.platform)
    now = service.clock()
    if not service.aliases.admit(name, now) or not is_public(name):
        return
    alias = service.store.aliases.get(alias_digest(*name))
    if alias is not None and alias.is_fresh(now):
        return
    sender = source(service.settings.contributor_secret, call.address)
    new = NewAlias(label=request.camera, platform=request.platform, source=sender)
    _queue(service, RefitRequest(camera=found.key, img_size=request.img_size, zoom=request.zoom, alias=new))


def _queue(service: Service, request: RefitRequest) -> None:
    """Have misses or an alias stored; no response depends on it."""

    def write() -> None:
        try:
            service.store.refit.later(request)
        except UnavailableError as error:
            _log.warning("misses or an alias were not reported: %s", error.detail)

    service.write_later(write)


def is_public(name: tuple[str, str]) -> bool:
    """True if a label contains nothing of a person, so that it may be stored."""
    label, platform = name
    return public_label(label) == label and public_platform(platform) == platform


def known(call: application.Call) -> Response:
    """Answer a lookup by the digest of label and platform: the same for all callers."""
    wanted = _query_of(call.path("size"), call.path("zoom"), call.path("file"))
    digest = call.path("digest")
    alias = call.service.store.aliases.get(digest) if wanted and _DIGEST.fullmatch(digest) else None
    if wanted is None or alias is None:
        return _unknown("unknown_camera")
    read = functools.cache(call.service.store.cameras.known)
    private = call.service.settings.thresholds.min_contributors == 1
    query = replace(wanted, camera=alias.label, platform=alias.platform)
    found = find(read, query, private=private, compute=lambda _key, _size: None)
    metrics.count(call.service.clock(), Lookups=1)
    if found.answer is None:
        return _unknown(found.reason)
    content = found.answer.model_dump_json().encode()
    tag = f'"{hashlib.sha256(content).hexdigest()[:32]}"'
    headers = {"Cache-Control": _KNOWN_CACHE, "ETag": tag, "Access-Control-Allow-Origin": "*"}
    if call.request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=headers)
    return Response(content, 200, headers, "application/json")


def _query_of(size: str, zoom: str, file: str) -> LookupQuery | None:
    """Parse the path of `known`; None if it has another form, so that each answer has one address."""
    model = file.removesuffix(".json")
    match = _SIZE.fullmatch(size)
    if match is None or not _ZOOM.fullmatch(zoom) or model not in DISTORTION_MODELS or model == file:
        return None
    img_size = int(match[1]), int(match[2])
    if size_text(img_size) != size or zoom_text(float(zoom)) != zoom:
        return None
    return LookupQuery("", "", img_size, float(zoom), model)


def _unknown(reason: Reason) -> Response:
    headers = {"Cache-Control": _UNKNOWN_CACHE, "Access-Control-Allow-Origin": "*"}
    return application.json_response(UnknownCamera(reason=reason), 404, headers)


def _key(request: LookupRequest) -> dict[str, str]:
    return {
        "camera": request.camera,
        "platform": request.platform,
        "img_size": size_text(request.img_size),
        "zoom": zoom_text(request.zoom),
        "distortion_model": request.distortion_model,
    }


handler = application.handler(
    application.route("/v1/lookup", is_quick=True, POST=ask, GET=visit),
    application.route("/known/v1/{digest}/{size}/{zoom}/{file}", is_quick=True, GET=known),
)
