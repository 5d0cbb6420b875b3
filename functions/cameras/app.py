"""Cameras: a search by words, and all that is known of one camera."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

from starlette.responses import Response

from calibdb.camera_key import PATTERN
from calibdb.errors import InvalidError, NotFoundError
from calibdb.http import application
from calibdb.lookup import camera_search
from calibdb.schema import ConsensusDocument
from calibdb.schema.cameras import CameraDetail, CameraList, CameraMode, CamerasRequest
from calibdb.store import StreamMode
from calibdb.store.cameras import is_place

_MAX_MEMBERS = 200
_MAX_MODES = 60  # sizes and zooms of a camera that are shown; anybody can add one
_READERS = 8  # cameras, or modes of one, read at a time
_PRIVATE_CACHE = {"Cache-Control": "private, max-age=60", "Vary": "Authorization"}


def search(call: application.Call) -> Response:
    """Answer with the cameras of whose names a word begins with every word asked for."""
    call.api_token()
    request = call.query(CamerasRequest)
    wanted = camera_search.query_words(request.query)
    least = call.service.settings.thresholds.min_contributors
    word = wanted[0] if wanted else ""
    if request.after is not None and not is_place(word, request.after):
        raise InvalidError.field("after", "must be the `next` value of an earlier answer to the same query")
    store = call.service.store.cameras
    found, following = store.search(word, request.limit, request.after)
    with ThreadPoolExecutor(_READERS) as readers:
        known = list(readers.map(lambda camera: store.known(camera[0]).consensuses, found))
    entries = (
        camera_search.camera_entry(key, name, consensuses)
        for (key, name), consensuses in zip(found, known, strict=True)
        if camera_search.is_listed(consensuses, least)
        and camera_search.has_words(wanted[1:], name, consensuses)
    )
    answer = CameraList(cameras=tuple({entry.key: entry for entry in entries}.values()), next=following)
    return application.json_response(answer, headers=_PRIVATE_CACHE)


def show(call: application.Call) -> Response:
    """Answer with one camera: what its calibrations are, and how far they agree."""
    call.api_token()
    key = call.path("key")
    store = call.service.store.cameras
    name = store.name(key) if PATTERN.fullmatch(key) else None
    if name is None and PATTERN.fullmatch(key):
        others = store.known(key).same_as  # a key of earlier rules, or of a name alone
        if len(others) == 1:
            key, name = others[0], store.name(others[0])
    if name is None:
        raise NotFoundError("The database has no camera with this key.")
    known = store.known(key).consensuses
    camera, platform = camera_search.display_name(name, known)
    shown = camera_search.best_modes(known, _MAX_MODES)
    with ThreadPoolExecutor(_READERS) as readers:
        modes = tuple(readers.map(lambda found: _mode(call, StreamMode(key, *found[0]), found[1]), shown))
    return application.json_response(
        CameraDetail(key=key, camera=camera, platform=platform, modes=modes), headers=_PRIVATE_CACHE
    )


def _mode(call: application.Call, mode: StreamMode, known: list[ConsensusDocument]) -> CameraMode:
    store = call.service.store
    best = camera_search.best_consensus(known)
    behind = store.consensuses.groups(best)
    groups = behind.groups if behind else ()
    return CameraMode(
        img_size=mode.img_size,
        zoom=mode.zoom,
        calibrations=max(c.total for c in known),
        contributors=best.calibration.contributors if best.calibration else 0,
        reason=None if best.reliable else best.reason,
        groups=groups,
        consensus={c.distortion_model: c.calibration for c in known if c.calibration},
        members=tuple(store.cameras.members(mode, frozenset(groups[0] if groups else ()), _MAX_MEMBERS)),
    )


handler = application.handler(
    application.route("/v1/cameras", GET=search),
    application.route("/v1/cameras/{key}", GET=show),
)
