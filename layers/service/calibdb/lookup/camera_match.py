"""Match of a lookup: the camera by USB id and name, or only by name, and its consensus.

A name of many products, or of two well-known USB ids, finds no camera.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from pydantic import ValidationError

from calibdb.camera_key import Identity, identify
from calibdb.errors import NotFoundError
from calibdb.lookup.transfer import bracketing_zooms, build_answer, closeness, interpolate_zoom
from calibdb.schema import Calibration, CheckRequest, ConsensusDocument, LookupAnswer, LookupRequest
from calibdb.schema.fields import CROPPED, StreamKey, size_text, zoom_text
from calibdb.schema.lookup import Reason
from calibdb.store import CameraRecords, Store, StreamMode

VIRTUAL = "This is a virtual camera: a program without a lens of its own."
AMBIGUOUS = "Many cameras have this name. Send a label with a USB id, or a platform with the device's model."
SEVERAL = "Several cameras have this name. Send the USB id, which Chromium gives, or calibrate the camera."
RESIZED = "The browser crops this stream; open it with resizeMode: none."

_DIGEST = re.compile("[0-9a-f]{32}")
_NO_CALIBRATION = "The database has no reliable calibration of this camera."
_MISS_DETAILS = {
    "unknown_camera": _NO_CALIBRATION,
    "too_few": "The database has too few calibrations of this camera.",
    "disagree": "The calibrations of this camera disagree.",
    "few_contributors": "The calibrations of this camera come from too few contributors.",
    "imprecise": "The calibrations of this camera agree, and leave it too uncertain.",
}


@dataclass(frozen=True)
class Choice:
    """Selected consensus, a size at which to compute the model, or the reason for a miss."""

    found: ConsensusDocument | None = None
    missing_at: tuple[int, int] | None = None
    reason: Reason = "unknown_camera"


@dataclass(frozen=True)
class CameraMatch:
    """Key of a camera, its consensuses, and the choice for the request."""

    key: str
    known: Sequence[ConsensusDocument]
    choice: Choice
    several: bool = False  # the name is that of more than one camera

    @property
    def has_answer(self) -> bool:
        """True if there is an answer, or will be once it is computed."""
        return self.choice.found is not None or self.choice.missing_at is not None


def choose(known: Sequence[ConsensusDocument], img_size: tuple[int, int], zoom: float, model: str) -> Choice:
    """Choose among all consensuses of a camera.

    Another zoom is other optics and never a result. The exact size comes first, then the closest: by aspect,
    then by area. `missing_at` is the best size at which only another model has a current consensus; `reason`
    is that of the exact size.
    """
    here: dict[tuple[tuple[int, int], str], ConsensusDocument] = {
        (c.img_size, c.distortion_model): c for c in known if c.zoom == zoom
    }
    for size in sorted({size for size, _ in here}, key=lambda s: closeness(s, img_size)):
        requested = here.get((size, model))
        if requested is not None and requested.reliable:
            return Choice(found=requested)
        others = [c for (other, _), c in here.items() if other == size and c.reliable]
        # Not computed yet, or not since the calibrations came in that made another model reliable.
        if any(
            requested is None or (requested.total, requested.latest) < (c.total, c.latest) for c in others
        ):
            return Choice(missing_at=size)
    order = sorted(here.items(), key=lambda known: known[0][1] != model)
    exact = [c.reason for (size, _), c in order if size == img_size and c.reason]
    return Choice(reason=exact[0] if exact else "too_few" if here else "unknown_camera")


def unanswerable_reason(query: StreamKey, *, private: bool) -> str | None:
    """Reason why nothing can be said of such a camera, else None."""
    if identify(query.camera, query.platform).virtual:
        return VIRTUAL
    if query.resize_mode == CROPPED:
        return RESIZED
    return AMBIGUOUS if identify(query.camera, query.platform).ambiguous and not private else None


def resolve(read: Callable[[str], CameraRecords], query: StreamKey, *, private: bool) -> CameraMatch:
    """Resolve a query to the key under which its camera is known (docs/camera-keys.md, "In which order").

    `private`: the database is that of one person, who has few cameras. `read` is called at most twice, and
    once if the camera is known under its own key and no other of its name is well known.
    """
    search = _Search(read, query, identify(query.camera, query.platform), private)
    own, has_id, is_distinct = search.own, search.identity.usb_id is not None, search.identity.distinct
    if own.has_answer:
        return own if private or has_id or not is_distinct else _best_supported(search)
    if not (private or is_distinct):
        return own
    return _name_of_unknown_id(search) if has_id else _only_usb_id(search)


@dataclass(frozen=True)
class _Search:
    read: Callable[[str], CameraRecords]
    query: StreamKey
    identity: Identity
    private: bool

    @functools.cached_property
    def known(self) -> CameraRecords:
        return self.read(self.identity.key)

    @functools.cached_property
    def own(self) -> CameraMatch:
        return self.match(self.identity.key, self.known)

    def match(self, key: str, known: CameraRecords) -> CameraMatch:
        query = self.query
        choice = choose(known.consensuses, query.img_size, query.zoom, query.distortion_model)
        return CameraMatch(key, known.consensuses, choice)

    def prefer(self, key: str, known: CameraRecords) -> CameraMatch:
        """Match `key`, unless only the camera's own key says why there is no answer."""
        other = self.match(key, known)
        return other if other.has_answer or self.own.choice.reason == "unknown_camera" else self.own


def _best_supported(search: _Search) -> CameraMatch:
    """Match the only well-known USB id of a name if more contributors calibrated it."""
    if len(search.known.well_known) != 1:
        return search.own
    key = search.known.well_known[0]
    other = search.match(key, search.read(key))
    return other if _outnumbers(other.choice.found, search.own.choice.found) else search.own


def _only_usb_id(search: _Search) -> CameraMatch:
    """Match the only USB id of a bare name."""
    candidates = search.known.same_as if search.private else search.known.candidates
    if len(candidates) > 1:
        return replace(search.own, several=True)
    # Calibrations that disagree under the bare name say that several cameras bear it.
    if not candidates or search.own.choice.reason == "disagree":
        return search.own
    return search.prefer(candidates[0], search.read(candidates[0]))


def _name_of_unknown_id(search: _Search) -> CameraMatch:
    """Match the name of an unknown USB id, unless it belongs to another id."""
    if search.known.consensuses:
        return search.own
    key = search.identity.name_key
    named = search.read(key)
    owners = named.same_as if search.private else named.well_known
    if any(owner != search.identity.key for owner in owners):
        return search.own
    return search.prefer(key, named)


def _outnumbers(other: ConsensusDocument | None, own: ConsensusDocument | None) -> bool:
    """True if more contributors are behind `other`, of the same size."""
    if other is None or own is None or other.calibration is None or own.calibration is None:
        return False
    more = other.calibration.contributors > own.calibration.contributors
    return more and other.img_size == own.img_size


@dataclass(frozen=True)
class LookupResult:
    """Answer of a lookup, or the reason for a miss, by name and as a sentence."""

    key: str
    """Key of the camera with the result; empty if the camera is unknown."""
    answer: LookupAnswer | None
    reason: Reason = "unknown_camera"
    detail: str = _NO_CALIBRATION
    known: Sequence[ConsensusDocument] = ()
    """All consensuses of a camera without answer: evidence for an estimate."""


def find(
    read: Callable[[str], CameraRecords],
    wanted: StreamKey,
    *,
    private: bool,
    compute: Callable[[str, tuple[int, int]], ConsensusDocument | None],
) -> LookupResult:
    """Result of a lookup.

    `read`, `private`: as of `resolve`. `compute`: computes the model of a camera key at a size.
    """
    size, zoom, model = wanted.img_size, wanted.zoom, wanted.distortion_model
    why = unanswerable_reason(wanted, private=private)
    if why is not None:
        return LookupResult("", None, detail=why)
    resolved = resolve(read, wanted, private=private)
    consensus, reason = resolved.choice.found, resolved.choice.reason
    if resolved.choice.missing_at is not None:
        consensus = compute(resolved.key, resolved.choice.missing_at)
        reason = consensus.reason if consensus and consensus.reason else reason
    if consensus is not None and consensus.reliable and consensus.calibration is not None:
        return LookupResult(resolved.key, build_answer(consensus.calibration, resolved.known, size))
    around = bracketing_zooms(resolved.known, size, zoom, model)
    if around is not None:
        return LookupResult(resolved.key, interpolate_zoom(*around, zoom))
    detail = SEVERAL if resolved.several else _MISS_DETAILS[reason]
    return LookupResult(resolved.key, None, reason, detail, resolved.known)


def find_by_digest(store: Store, digest: str, address: str, *, private: bool) -> LookupResult | None:
    """Result of a lookup by an alias's digest and `<size>/<zoom>/<model>.json`; None if it is unknown."""
    wanted = _parse_address(address)
    alias = store.aliases.get(digest) if wanted and _DIGEST.fullmatch(digest) else None
    if wanted is None or alias is None:
        return None
    query = wanted.model_copy(update={"camera": alias.label, "platform": alias.platform})
    read = functools.cache(store.cameras.known)
    return find(read, query, private=private, compute=lambda _key, _size: None)


def _parse_address(address: str) -> LookupRequest | None:
    """Request of an alias; None unless this is the only address of its answer."""
    size, zoom, file = address.split("/")
    model = file.removesuffix(".json")
    fields = {"camera": "-", "platform": "-", "img_size": size, "zoom": zoom, "distortion_model": model}
    try:
        wanted = LookupRequest.model_validate(fields)
    except ValidationError:
        return None
    same = f"{size_text(wanted.img_size)}/{zoom_text(wanted.zoom)}/{wanted.distortion_model}.json"
    return wanted if same == address else None


def find_checked(store: Store, request: CheckRequest, *, private: bool) -> tuple[StreamMode, Calibration]:
    """Consensus to check, reliable or not, and its mode; raises NotFoundError.

    As a lookup would find it, but only at the size and zoom of the views.
    """
    size, zoom, model = request.img_size, request.zoom, request.distortion_model
    if unanswerable_reason(request, private=private) is None:
        resolved = resolve(store.cameras.known, request, private=private)
        mode = StreamMode(resolved.key, size, zoom)
        here = [c for c in resolved.known if (c.img_size, c.zoom) == (size, zoom)]
        consensus = consensus_of_model(here, model) or (store.refit.consensus(mode, model) if here else None)
        if consensus is not None and consensus.calibration is not None:
            return mode, consensus.calibration
    raise NotFoundError(
        "The database has no consensus to check for this camera at this size; cropped streams have none.",
        kind="no-calibration",
    )


def consensus_of_model(documents: Sequence[ConsensusDocument], model: str) -> ConsensusDocument | None:
    """Consensus of this model, None if there is none."""
    return next((d for d in documents if d.distortion_model == model), None)
