"""Reports of lookups: misses, counted by camera, and names of cameras, which become aliases."""

import threading
from collections import Counter
from collections.abc import Callable

from calibdb.camera_key import identify, public_label, public_platform
from calibdb.lookup.camera_match import LookupResult
from calibdb.lookup.camera_search import is_listed
from calibdb.schema import LookupRequest, NewAlias, RefitRequest
from calibdb.store import CameraRecords, Store
from calibdb.store.aliases import Alias
from calibdb.store.miss_counts import USB

REPORT_S = 600  # between two reports of an instance, which loses its counts when it ends
MAX_CAMERAS = 50

_DAY_S = 86_400
_MAX_ALIASES = 4096


class MissCounter:
    """Counts of cameras since the last report. Thread-safe."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._next_report = 0.0
        self._lock = threading.Lock()

    def count(self, camera: str, now: float) -> dict[str, int]:
        """Count a miss; return the counts that are to be reported now."""
        with self._lock:
            if camera in self._counts or len(self._counts) < MAX_CAMERAS:
                self._counts[camera] += 1
            if now < self._next_report:
                return {}
            counts, self._counts = dict(self._counts), Counter()
            self._next_report = now + REPORT_S
            return counts


class AliasFilter:
    """Aliases of the last day. Thread-safe."""

    def __init__(self) -> None:
        self._day = 0
        self._seen: set[tuple[str, str]] = set()
        self._lock = threading.Lock()

    def admit(self, name: tuple[str, str], now: float) -> bool:
        """True for the first lookup under a label and platform on a day."""
        day = int(now) // _DAY_S
        with self._lock:
            if day != self._day or len(self._seen) >= _MAX_ALIASES:
                self._day, self._seen = day, set()
            is_new = name not in self._seen
            self._seen.add(name)
            return is_new


def miss_report(
    counter: MissCounter,
    request: LookupRequest,
    read: Callable[[str], CameraRecords],
    found: LookupResult,
    now: float,
    min_contributors: int,
) -> RefitRequest | None:
    """Count a miss; return the counts if they are due.

    By the camera's key only if others have calibrated it, since a key has parts of a label; else by its USB
    id.
    """
    if not found.key:
        return None
    consensuses = read(found.key).consensuses
    usb_id = identify(request.camera, request.platform).usb_id
    if consensuses and is_listed(consensuses, max(2, min_contributors)):
        camera = found.key
    elif usb_id is not None:
        camera = USB + usb_id
    else:
        return None
    counted = counter.count(camera, now)
    return RefitRequest(camera=found.key, img_size=request.img_size, misses=counted) if counted else None


def alias_report(
    seen: AliasFilter,
    store: Store,
    request: LookupRequest,
    key: str,
    now: float,
    sender: Callable[[], str],
) -> RefitRequest | None:
    """Request to store the name of a lookup as an alias of a camera; None if it is not new."""
    name = request.camera, request.platform
    if not seen.admit(name, now) or not is_public(name):
        return None
    alias = store.aliases.get(Alias(*name).digest)
    if alias is not None and alias.is_fresh(now):
        return None
    new = NewAlias(label=request.camera, platform=request.platform, source=sender())
    return RefitRequest(camera=key, img_size=request.img_size, zoom=request.zoom, alias=new)


def is_public(name: tuple[str, str]) -> bool:
    """True if a label contains nothing of a person, so that it may be stored."""
    label, platform = name
    return public_label(label) == label and public_platform(platform) == platform
