"""Filter of the sightings that one instance of `lookup` reports: each once, and few of one source.

Anybody can invent labels. So a source reports a handful of aliases of a camera in an hour, and what is
remembered here is bounded. `calibdb.lookup.publication` bounds what is written down.
"""

from __future__ import annotations

import threading
from collections import OrderedDict

from calibdb.lookup.publication import MAX_PENDING_PER_SOURCE

_HOUR_S = 3600
_MAX_SENDERS = 4096  # cameras and sources that are remembered


class SightingFilter:
    """Sightings of the last hour. Safe from many threads at once."""

    def __init__(self) -> None:
        self._reported: OrderedDict[tuple[str, str, int], set[tuple[str, str]]] = OrderedDict()
        self._lock = threading.Lock()

    def admit(self, camera_key: str, name: tuple[str, str], source: str, now: float) -> bool:
        """Tell whether to report that this source asked for the camera by label and platform."""
        sender = camera_key, source, int(now) // _HOUR_S
        with self._lock:
            reported = self._reported.setdefault(sender, set())
            self._reported.move_to_end(sender)
            while len(self._reported) > _MAX_SENDERS:
                self._reported.popitem(last=False)
            if name in reported or len(reported) >= MAX_PENDING_PER_SOURCE:
                return False
            reported.add(name)
            return True
