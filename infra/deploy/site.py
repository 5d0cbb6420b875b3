"""The static client as it is uploaded: names, types, encodings, and how long each file may be kept."""

import gzip
import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from calibdb.store.dumps import CACHE_CONTROL, JSON, NO_STATISTICS, STATISTICS
from infra.deploy import hashed_names
from infra.web_build import site
from infra.web_build.root_files import robots_text, security_text, shell_of, sitemap
from infra.web_build.sdk import VERSIONED, digest
from infra.web_build.site_headers import FOREVER, media_type

# Files whose names change with their contents are kept for good. Everything else the edge keeps until the
# upload says otherwise, and browsers ask the edge whether it changed.
FRESH = "public, max-age=0, s-maxage=31536000, must-revalidate"
_NO_STORE = "no-store"  # of the settings, which hold the page's token
_MAX_EDGE_COMPRESSED_BYTES = 10_000_000  # CloudFront developer guide, "Serving compressed files"
_VENDOR = "vendor/"
_REFERENCING_SUFFIXES = (".html", ".css", ".js", ".webmanifest")  # files that may name others
_EXCLUDED_SUFFIXES = (".d.ts", "tsconfig.json", ".made")


@dataclass(frozen=True)
class Upload:
    """One object of the web bucket."""

    key: str
    content: bytes
    content_type: str
    cache_control: str
    content_encoding: str | None = None
    is_versioned: bool = False
    """True if the object never changes once it exists."""
    is_initial: bool = False
    """True if the object is written only where none has its name."""


def uploads(
    web: Path,
    settings: Mapping[str, Any],
    contact: str | None = None,
    now: datetime | None = None,
    options: site.Options | None = None,
) -> Iterator[Upload]:
    """Yield everything to upload, pages after what they load; then the list of it all.

    `web`: the client, with `vendor/`. `settings`: content of `/config.json`. Without `contact` and `now`
    there is no `security.txt`, without an origin in `options` neither `robots.txt` nor a sitemap.
    """
    files = {
        path.relative_to(web).as_posix(): path.read_bytes()
        for path in sorted(web.rglob("*"))
        if path.is_file()
        and not path.name.endswith(_EXCLUDED_SUFFIXES)
        and path.relative_to(web).parts[0] not in site.SOURCE_FOLDERS
    } | dict(site.made_files(web, options))
    origin = options.origin if options else ""
    vendor = f"vendor-{digest({k: v for k, v in files.items() if k.startswith(_VENDOR)})[:12]}/"
    own = hashed_names.hashed(files)
    named = digest({**own, vendor: b""})[:12]
    files = hashed_names.rename(files, named)
    digests: dict[str, str] = {}
    for key in sorted(files, key=lambda key: (key.endswith(".html"), key)):
        file = _upload(key, files[key], vendor, named)
        content = gzip.decompress(file.content) if file.content_encoding else file.content
        if key not in own:  # pages load their hashed copy
            digests[file.key] = hashlib.sha256(content).hexdigest()
        yield file
    # Pages ask for the figures before the first dump has written them.
    yield Upload(STATISTICS, NO_STATISTICS, JSON, CACHE_CONTROL[JSON], is_initial=True)
    # What the service worker of the pages keeps, by the names and contents that a browser gets.
    made = {"shell.json": json.dumps(shell_of(digests)).encode()}
    if contact and now:
        made[".well-known/security.txt"] = security_text(contact, now, origin)
    if origin:
        made["robots.txt"] = robots_text(origin)
        made["sitemap.xml"] = sitemap(origin, digests)
    for key, content in made.items():
        yield Upload(key, content, media_type(key), FRESH)
    yield Upload("config.json", json.dumps(dict(settings)).encode(), "application/json", _NO_STORE)


def _upload(key: str, content: bytes, vendor: str, named: str) -> Upload:
    is_immutable = key.startswith(_VENDOR) or f"-{named}." in key
    if key.startswith(_VENDOR):
        key = vendor + key.removeprefix(_VENDOR)
    elif key.endswith(_REFERENCING_SUFFIXES) and not VERSIONED.match(key):
        content = re.sub(rb"(?<=[\"'/(])vendor/", vendor.encode(), content)
    versioned = VERSIONED.match(key) is not None
    large = len(content) > _MAX_EDGE_COMPRESSED_BYTES
    return Upload(
        key=key,
        content=gzip.compress(content, mtime=0) if large else content,
        content_type=media_type(key),
        cache_control=FOREVER if is_immutable or versioned else FRESH,
        content_encoding="gzip" if large else None,
        is_versioned=versioned,
    )
