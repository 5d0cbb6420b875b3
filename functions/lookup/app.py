"""Lookup: the calibration of the camera that a page just opened, or the way to one.

A lookup that hits is one Query. No lookup writes for itself: tokens are read twice a minute, and lookups are
counted in memory and flushed in batches (`calibdb.access.token_cache`). The first hits under a label and
platform that are new for the camera are reported to `refit`, which lets the edge answer the next ones.
"""

from __future__ import annotations

import functools
import logging
from collections.abc import Callable
from urllib.parse import urlencode

from starlette.responses import Response

from calibdb.access.tokens import source
from calibdb.camera_key import identify
from calibdb.errors import NotFoundError, UnavailableError
from calibdb.http import application, metrics
from calibdb.lookup.calibration_lookup import LookupQuery, LookupResult, find
from calibdb.lookup.camera_search import is_listed
from calibdb.lookup.edge_content import is_public
from calibdb.lookup.estimation import estimate_for
from calibdb.schema import ConsensusDocument, LookupRequest, Miss, NoCalibration, RefitRequest, Sighting
from calibdb.schema.fields import size_text, zoom_text
from calibdb.store import CameraRecords
from calibdb.store.keys import alias_digest
from calibdb.store.miss_counts import USB

# By browsers, and at the edge for the same token from the same origin; both may be refused.
_PUBLIC_CACHE = {"Cache-Control": "public, max-age=20", "Vary": "Authorization, Origin"}

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
    found = _find(call, request)
    now = call.service.clock()
    if found.answer is not None:
        metrics.count(now, Lookups=1)
        return application.json_response(
            found.answer, headers=_PUBLIC_CACHE if call.request.method != "POST" else None
        )
    url = call.service.settings.guidance_url + "?" + urlencode(_key(request))
    likely = estimate_for(request, found.known)
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
        refit = RefitRequest(camera=key, img_size=size, zoom=zoom, models=(model,))
        return store.refit.now(refit).models.get(model)

    wanted = LookupQuery(request.camera, request.platform, size, zoom, model, request.resize_mode)
    private = call.service.settings.thresholds.min_contributors == 1
    found = find(read, wanted, private=private, compute=compute)
    if found.answer is not None and call.request.method == "POST":
        _report(call, request, read, found)
    elif found.answer is None and found.key:
        _count_miss(call, request, read, found)
    return found


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
    asked = RefitRequest(camera=found.key, img_size=request.img_size, misses=counted)
    try:
        service.store.refit.later(asked)
    except UnavailableError as error:  # the answer does not depend on it
        _log.warning("misses were not reported: %s", error.detail)


def _report(
    call: application.Call, request: LookupRequest, read: Callable[[str], CameraRecords], found: LookupResult
) -> None:
    """Have an alias that is new written down, so that the edge answers under it; nobody waits for that."""
    service, identity = call.service, identify(request.camera, request.platform)
    name = request.camera, request.platform
    if not service.settings.edge_answers or (identity.usb_id and found.key != identity.key):
        return
    sender = source(service.settings.contributor_secret, call.address)
    if not read(identity.key).aliases.wants(alias_digest(*name)):
        return
    if not (is_public(name) and service.sightings.admit(identity.key, name, sender, service.clock())):
        return
    sighting = Sighting(label=request.camera, platform=request.platform, source=sender)
    asked = RefitRequest(camera=identity.key, img_size=request.img_size, zoom=request.zoom, sighting=sighting)
    try:
        service.store.refit.later(asked)
    except UnavailableError as error:  # the answer does not depend on it
        _log.warning("an alias was not reported: %s", error.detail)


def _key(request: LookupRequest) -> dict[str, str]:
    return {
        "camera": request.camera,
        "platform": request.platform,
        "img_size": size_text(request.img_size),
        "zoom": zoom_text(request.zoom),
        "distortion_model": request.distortion_model,
    }


handler = application.handler(application.route("/v1/lookup", POST=ask, GET=visit))
