"""Headers and encoding of the site's files, at the edge and on a server."""

import gzip
import mimetypes
from pathlib import Path

from infra.web_build.sdk import VERSIONED

FOREVER = "public, max-age=31536000, immutable"
"""Of what has a name that changes with its content."""
FOR_EVERYONE = {"access-control-allow-origin": "*", "cross-origin-resource-policy": "cross-origin"}
CONTENT_SECURITY_POLICY = (
    "default-src 'self'; img-src 'self' blob: data:; media-src 'self' blob:; connect-src 'self'; "
    "script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; worker-src 'self'; frame-ancestors 'none'; "
    "base-uri 'none'; form-action 'self'; object-src 'none'"
)
# What pages of other origins load: a module is always requested with CORS, and the SDK reads the settings.
_CROSS_ORIGIN = ("sdk/", "webxr/", "vendor/webxr/", "openapi.json", "config.json")
# What the machine's own tables may lack or call otherwise; a browser is particular about these.
_TYPES = {
    ".js": "text/javascript",
    ".json": "application/json",
    ".mjs": "text/javascript",
    ".svg": "image/svg+xml",
    ".tgz": "application/gzip",
    ".wasm": "application/wasm",
    ".webmanifest": "application/manifest+json",
    ".woff2": "font/woff2",
}
_COMPRESSIBLE = (".css", ".html", ".js", ".json", ".mjs", ".svg", ".txt", ".wasm", ".webmanifest", ".xml")
_MIN_COMPRESSED_BYTES = 500


def headers(key: str) -> dict[str, str]:
    """Return the headers that a file is served with, except those about its content."""
    return {
        # A file may have changed with the next save: ask each time, mostly to hear 304.
        "cache-control": FOREVER if VERSIONED.match(key) else "no-cache",
        "content-security-policy": CONTENT_SECURITY_POLICY,
        "cross-origin-opener-policy": "same-origin",
        "referrer-policy": "strict-origin-when-cross-origin",
        "x-content-type-options": "nosniff",
    } | (FOR_EVERYONE if key.startswith(_CROSS_ORIGIN) else {})


def media_type(key: str) -> str:
    """Return the content type of a file by its name."""
    kind = _TYPES.get(Path(key).suffix.lower()) or mimetypes.guess_type(key)[0] or "application/octet-stream"
    return f"{kind}; charset=utf-8" if kind.startswith("text/") else kind


def compress(key: str, content: bytes, level: int = 6) -> bytes | None:
    """Return the content of a file compressed by gzip; None if it is served as it is."""
    if Path(key).suffix not in _COMPRESSIBLE or len(content) < _MIN_COMPRESSED_BYTES:
        return None
    return gzip.compress(content, level, mtime=0)
