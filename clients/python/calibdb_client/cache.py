"""Cache on disk of the edge's answers, for as long as the service allows; no credential is in them."""

import hashlib
import json
import os
import re
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

MAX_FILES = 500
MAX_AGE_S = 24 * 3600
"""Maximum time for which a response is cached, whatever its headers say."""


class Cache:
    """Answers by address, in a folder that only its owner can read. `clock` gives Unix seconds.

    A cache that cannot be read or written is an empty one: no lookup fails for that.
    """

    def __init__(self, folder: Path, clock: Callable[[], float]) -> None:
        self.folder = folder
        self._clock = clock

    def get(self, address: str) -> dict[str, Any] | None:
        """Return the fresh response, or None."""
        try:
            entry = json.loads(self._path(address).read_bytes())
            fresh = 0 < entry["expires"] - self._clock() <= MAX_AGE_S
            return entry["answer"] if fresh and isinstance(entry["answer"], dict) else None
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def put(self, address: str, answer: Mapping[str, Any], headers: Mapping[str, str]) -> None:
        """Cache a response for the time that its `Cache-Control` allows; without one, not at all."""
        lifetime = max_age(headers)
        if lifetime <= 0:
            return
        content = json.dumps({"expires": self._clock() + lifetime, "answer": dict(answer)})
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._prune()
            # mkstemp makes the file readable only by its owner
            handle, name = tempfile.mkstemp(dir=self.folder, prefix=".")
            try:
                with os.fdopen(handle, "w", encoding="utf-8") as file:
                    file.write(content)
                Path(name).replace(self._path(address))
            except OSError:
                Path(name).unlink(missing_ok=True)
        except OSError:
            return

    def _path(self, address: str) -> Path:
        return self.folder / f"{hashlib.sha256(address.encode()).hexdigest()[:32]}.json"

    def _prune(self) -> None:
        files = sorted(self.folder.glob("*.json"), key=lambda path: path.stat().st_mtime)
        for path in files[: max(0, len(files) - MAX_FILES + 1)]:
            path.unlink(missing_ok=True)


def max_age(headers: Mapping[str, str]) -> int:
    """Seconds for which `Cache-Control` lets a private cache keep a response; 0: not at all."""
    control = headers.get("cache-control", "").lower()
    if "no-store" in control or "no-cache" in control:
        return 0
    match = re.search(r"(?:^|[,\s])max-age=(\d{1,9})", control)
    return min(int(match[1]), MAX_AGE_S) if match else 0


def default_folder() -> Path:
    """Return the folder of caches that the system's users expect."""
    if override := os.environ.get("XDG_CACHE_HOME"):
        return Path(override) / "calibdb"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home()) / "calibdb" / "Cache"
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "calibdb"
    return Path.home() / ".cache" / "calibdb"
