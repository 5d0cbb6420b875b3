"""Cameras: a search by words, all that is known of one camera, and its badge."""

import functools
from concurrent.futures import ThreadPoolExecutor

from starlette.responses import Response

from calibdb.camera_key import PATTERN
from calibdb.camera_key.virtual import is_practice
from calibdb.errors import InvalidError, NotFoundError
from calibdb.http import application
from calibdb.http.application import Call, json_response, route
from calibdb.lookup import camera_search
from calibdb.lookup.badge import NOT_CALIBRATED, badge_of, parse_size, svg
from calibdb.schema.cameras import CameraDetail, CameraList, CamerasRequest
from calibdb.store import StreamMode
from calibdb.store.cameras import is_place

_MAX_MODES = 60  # shown of a camera
_READERS = 8
_BADGE_HEADERS = {
    "Cache-Control": "public, max-age=300",
    "Content-Security-Policy": "default-src 'none'",
}
_PRIVATE_CACHE = {"Cache-Control": "private, max-age=60", "Vary": "Authorization"}


def search(call: Call) -> Response:
    """Search cameras by the beginnings of words."""
    call.api_token()
    request = call.query(CamerasRequest)
    terms = camera_search.query_words(request.query)
    thresholds = call.service.settings.thresholds
    word = terms[0] if terms else ""
    if request.after is not None and not is_place(word, request.after):
        raise InvalidError.field("after", "must be the `next` value of an earlier answer to the same query")
    store = call.store.cameras
    cameras, following = store.search(word, request.limit, request.after)
    if not word:
        # Practice captures create cameras, which are found only by their name.
        real = [camera for camera in cameras if not is_practice(camera[1])]
        if cameras and is_practice(cameras[-1][1]) and following is not None:
            following = camera_search.AFTER_PRACTICE
        cameras = real
    with ThreadPoolExecutor(_READERS) as readers:
        consensus_lists = list(readers.map(lambda camera: store.known(camera[0]).consensuses, cameras))
    entries = (
        camera_search.camera_entry(key, name, consensuses, thresholds.min_calibrations)
        for (key, name), consensuses in zip(cameras, consensus_lists, strict=True)
        if camera_search.is_listed(consensuses, thresholds.min_contributors)
        and request.reliable in (None, any(c.reliable for c in consensuses))
        and camera_search.has_words(terms[1:], name, consensuses)
    )
    answer = CameraList(cameras=tuple({entry.key: entry for entry in entries}.values()), next=following)
    return json_response(answer, headers=_PRIVATE_CACHE)


def show(call: Call) -> Response:
    """One camera with its calibrations and their agreement."""
    call.api_token()
    key = call.path("key")
    store = call.store.cameras
    name = store.name(key) if PATTERN.fullmatch(key) else None
    if name is None and PATTERN.fullmatch(key):
        others = store.known(key).same_as  # a key of earlier rules, or of a name alone
        if len(others) == 1:
            key, name = others[0], store.name(others[0])
    if name is None:
        raise NotFoundError("The database has no camera with this key.")
    consensuses = store.known(key).consensuses
    shown = camera_search.best_modes(consensuses, _MAX_MODES)
    least = call.service.settings.thresholds.min_calibrations
    mode_of = functools.partial(camera_search.camera_mode, call.store, least)
    with ThreadPoolExecutor(_READERS) as readers:
        modes = tuple(readers.map(lambda found: mode_of(StreamMode(key, *found[0]), found[1]), shown))
    detail = CameraDetail(**dict(camera_search.named_camera(key, name, consensuses)), modes=modes)
    return json_response(detail, headers=_PRIVATE_CACHE)


def badge(call: Call) -> Response:
    """Badge of a camera at a size, also of unknown ones."""
    key, img_size = call.path("key"), parse_size(call.path("file"))
    result = NOT_CALIBRATED
    if img_size is not None and PATTERN.fullmatch(key):
        thresholds = call.service.settings.thresholds
        consensuses = call.store.cameras.known(key).consensuses
        name = camera_search.display_name("", consensuses)[0]
        result = badge_of(name, consensuses, img_size, thresholds)
    return Response(svg(result), 200, _BADGE_HEADERS, "image/svg+xml")


handler = application.handler(
    route("/v1/cameras", GET=search),
    route("/v1/cameras/{key}", GET=show),
    route("/badge/{key}/{file}", GET=badge),
)
