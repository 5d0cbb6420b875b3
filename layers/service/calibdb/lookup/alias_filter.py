"""Filter of the aliases that one instance of `lookup` looks after: each once a day."""

from __future__ import annotations

import threading
from collections import OrderedDict

_DAY_S = 86_400
_MAX_ALIASES = 4096  # that are remembered


class AliasFilter:
    """Aliases of the last day. Safe from many threads at once."""

    def __init__(self) -> None:
        self._seen: OrderedDict[tuple[str, str], int] = OrderedDict()
        self._lock = threading.Lock()

    def admit(self, name: tuple[str, str], now: float) -> bool:
        """True for the first lookup under a label and platform on a day."""
        day = int(now) // _DAY_S
        with self._lock:
            if self._seen.get(name) == day:
                return False
            self._seen[name] = day
            self._seen.move_to_end(name)
            if len(self._seen) > _MAX_ALIASES:
                self._seen.popitem(last=False)
            return True
