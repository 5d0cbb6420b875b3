"""Misses that one instance of `lookup` counts: the first is reported at once, the others now and then."""

from __future__ import annotations

import threading
from collections import Counter

REPORT_S = 600  # seconds between two reports of an instance; what an instance that ends has counted is lost
MAX_CAMERAS = 50  # that are counted until then


class MissCounter:
    """Counts of cameras since the last report. Safe from many threads at once."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._next_report = 0.0
        self._lock = threading.Lock()

    def count(self, camera: str, now: float) -> dict[str, int]:
        """Count a miss; return what is to be reported now, mostly nothing."""
        with self._lock:
            if camera in self._counts or len(self._counts) < MAX_CAMERAS:
                self._counts[camera] += 1
            if now < self._next_report:
                return {}
            found, self._counts = dict(self._counts), Counter()
            self._next_report = now + REPORT_S
            return found
