"""Checks of the parts that the service needs, each with its own time limit, cached for some seconds.

A part that does not respond keeps its thread, and is not checked again meanwhile. Errors go only to the log.
"""

import json
import logging
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from calibdb.schema.health import PartHealth, PartName

CHECKS_TTL_S = 10.0  # in each instance of the function and at the edge

_MAX_CONFIG_BYTES = 10_000

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Part:
    """One part of the service; failing checks raise."""

    name: PartName
    limit_s: float
    check: Callable[[], object]
    prepare: Callable[[], object] = object
    """Imports what the check needs, and is not timed."""

    def measure(self) -> float:
        """Check the part; return the ms that it took."""
        self.prepare()
        start = time.perf_counter()
        self.check()
        return round(1000 * (time.perf_counter() - start), 1)


class PartChecks:
    """Parts, checked stage by stage, and in parallel within a stage."""

    def __init__(self, stages: Sequence[Sequence[Part]], clock: Callable[[], float] = time.monotonic) -> None:
        self._stages = stages
        self._clock = clock
        self._lock = threading.Lock()
        self._threads = ThreadPoolExecutor(sum(map(len, stages)), thread_name_prefix="check")
        self._running: dict[PartName, Future[float]] = {}
        self._known: tuple[PartHealth, ...] = ()
        self.checked_at = 0
        """Unix seconds of the last check."""
        self._until = float("-inf")

    def __call__(self) -> tuple[PartHealth, ...]:
        """Check all parts, at most once per `CHECKS_TTL_S`."""
        with self._lock:
            if self._clock() >= self._until:
                self._known = tuple(state for stage in self._stages for state in self._check(stage))
                self._until = self._clock() + CHECKS_TTL_S
                self.checked_at = int(time.time())
            return self._known

    def _check(self, stage: Sequence[Part]) -> list[PartHealth]:
        start = time.perf_counter()
        runs = [(part, self._begin(part)) for part in stage]
        return [_health(part, run, start + part.limit_s) for part, run in runs]

    def _begin(self, part: Part) -> Future[float] | None:
        """Start the check of a part; None if the last one has not ended yet."""
        before = self._running.get(part.name)
        if before is not None and not before.done():
            return None
        self._running[part.name] = run = self._threads.submit(part.measure)
        return run


def _health(part: Part, run: Future[float] | None, end: float) -> PartHealth:
    """Wait for a check until `end`, by the performance counter."""
    latency = None
    try:
        failed = run.exception(max(0.0, end - time.perf_counter())) if run is not None else TimeoutError()
    except TimeoutError as error:
        failed = error
    if failed is not None:
        _log.warning("the check of %s failed", part.name, exc_info=failed)
    elif run is not None:
        latency = run.result()
    limit_ms = round(1000 * part.limit_s)
    return PartHealth(part=part.name, ok=failed is None, latency_ms=latency, limit_ms=limit_ms)


class _Unredirected(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_: Any) -> None:
        """Follow no redirect."""


def read_file(address: str, limit_s: float, max_bytes: int) -> bytes:
    """Read the beginning of a file of the site; raises OSError."""
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}), _Unredirected)
    try:
        with opener.open(address, timeout=limit_s) as answer:
            content: bytes = answer.read(max_bytes)
            return content
    except urllib.error.HTTPError as error:
        error.close()
        raise


def read_config(address: str, limit_s: float) -> None:
    """Read the site's settings; raises OSError or ValueError."""
    if "api" not in json.loads(read_file(address, limit_s, _MAX_CONFIG_BYTES)):
        raise ValueError("/config.json has no settings")
