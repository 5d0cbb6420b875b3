"""Threads that functions run in."""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor


class Workers:
    """A pool of threads, each with an event loop set.

    On Lambda a handler runs in the main thread, and Mangum takes the event loop that this thread has; a
    thread of a plain pool has none.
    """

    def __init__(self, count: int, name: str):
        self._loops: list[asyncio.AbstractEventLoop] = []
        self._lock = threading.Lock()
        self.pool = ThreadPoolExecutor(count, thread_name_prefix=name, initializer=self._set_loop)

    def _set_loop(self) -> None:
        loop = asyncio.new_event_loop()
        asyncio.set_event_loop(loop)
        with self._lock:
            self._loops.append(loop)

    def close(self) -> None:
        """Let everything that was submitted finish, then end the threads."""
        self.pool.shutdown(wait=True)
        for loop in self._loops:
            loop.close()
        self._loops.clear()
