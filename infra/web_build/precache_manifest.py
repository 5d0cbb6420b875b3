"""Precache manifest of the service worker: files of the web client with the hashes of their contents.

    python -m infra.web_build.precache_manifest > shell.json

The local stack answers `/shell.json` itself; a deployment uploads the file with the pages.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import sys
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import TypedDict

from infra.web_build import site

WEB = Path(__file__).parents[2] / "web"
# Fetched when a page needs them, not with the first visit: 3 MB, or a rarely used script.
LAZY = re.compile(r"vendor(-[0-9a-f]+)?/(opencv/|font/geologica-cyrillic)")
SUFFIXES = (".html", ".js", ".css", ".svg", ".json", ".woff2", ".wasm")
# Sources of texts that pages contain, and what is for developers: of no use without a network, 3 MB.
EXCLUDED = re.compile(
    r"messages/|((de|uk)/)?(examples|docs)/|sdk/(\d|integrity)|vendor(-[0-9a-f]+)?/(engines|minisearch)/"
)
# Not for pages, or another with every server.
EXCLUDED_FILES = {"openapi.json", "tsconfig.json", "config.json", "shell.json", "sw.js"}


class Shell(TypedDict):
    """`version` changes with any content; `late` are kept when they are used."""

    version: str
    files: dict[str, str]
    late: list[str]


def shell(folder: Path = WEB, options: site.Options | None = None) -> Shell:
    """Return the list of the pages' files: path → SHA-256, hexadecimal.

    `options`: those that the pages are served with.
    """
    digests = {path.removeprefix(f"{folder}/"): _hash(path, *_state(path)) for path in _files(folder)}
    served = site.made_files(folder, options)
    made = {key: hashlib.sha256(content).hexdigest() for key, content in served.items()}
    return shell_of(dict(sorted((digests | made).items())))


def shell_of(digests: Mapping[str, str]) -> Shell:
    """Return the list of those among files, by path with their SHA-256, that belong to pages.

    The folder `vendor/` may have the hash in its name that an upload gives it.
    """
    files = {
        name: digest
        for name, digest in digests.items()
        if Path(name).suffix in SUFFIXES and name not in EXCLUDED_FILES and not EXCLUDED.match(name)
    }
    version = hashlib.sha256(json.dumps(files).encode()).hexdigest()[:16]
    return {
        "version": version,
        "files": files,
        "late": [name for name in files if LAZY.match(name)],
    }


def _files(folder: Path) -> Iterator[str]:
    """Paths as texts: they are walked for every visitor."""
    for place, _, names in os.walk(folder):
        yield from (f"{place}/{name}" for name in names if name.endswith(SUFFIXES))


def _state(path: str) -> tuple[int, int]:
    status = Path(path).stat()
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=1024)
def _hash(path: str, changed: int, size: int) -> str:  # noqa: ARG001 - the key of what is remembered
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


if __name__ == "__main__":
    json.dump(shell(), sys.stdout)
