"""The static site: its files with ETags, compressed where that helps, and the headers of a deployment."""

from __future__ import annotations

import asyncio
import gzip
import hashlib
import mimetypes
import time
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Protocol

from starlette.datastructures import Headers
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.types import Receive, Scope, Send

from infra.web_build import site
from infra.web_build.precache_manifest import shell
from infra.web_build.root_files import robots_text, security_text, sitemap
from infra.web_build.sdk import VERSIONED, SdkError

_POLICY = {
    "default-src": "'self'",
    "img-src": "'self' blob: data:",
    "media-src": "'self' blob:",
    "connect-src": "'self'",
    "script-src": "'self' 'wasm-unsafe-eval'",
    "style-src": "'self'",
    "worker-src": "'self'",
    "frame-ancestors": "'none'",
    "base-uri": "'none'",
    "form-action": "'self'",
    "object-src": "'none'",
}
# What pages of other origins load: a module is always requested with CORS.
SHARED = ("/sdk/", "/webxr/", "/vendor/webxr/", "/openapi.json")
FOREVER = "public, max-age=31536000, immutable"
"""Of what has a name that changes with its content."""
FOR_EVERYONE = {"access-control-allow-origin": "*", "cross-origin-resource-policy": "cross-origin"}

CHECK_INTERVAL_S = 1.0
_NO_CACHE = {"cache-control": "no-cache"}
_COMPRESSIBLE = (".css", ".html", ".js", ".json", ".mjs", ".svg", ".txt", ".wasm", ".webmanifest", ".xml")
_MAX_COMPRESSED_BYTES = 2_000_000  # more would take too long for a request

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


#: the page that stands for one that is missing, here and at the edge
NOT_FOUND = site.WEB / "404.html"


@dataclass(frozen=True)
class _File:
    """A file in memory, as it is sent."""

    content: bytes
    headers: list[tuple[bytes, bytes]]
    tag: bytes
    compressed: tuple[bytes, list[tuple[bytes, bytes]]] | None


class Pages:
    """ASGI application of the site: GET and HEAD of the pages and files, `index.html` for folders.

    Pages are made again when one of their sources has changed, which is checked at most once per
    `CHECK_INTERVAL_S`.

    Parameters
    ----------
    folder
        The static client.
    settings
        Content of `/config.json`.
    options
        Facts about the deployment that the pages contain.
    """

    def __init__(
        self, folder: Path, settings: Mapping[str, Any], options: site.Options | None = None
    ) -> None:
        self._folder = folder.resolve()
        self._settings = settings
        self._options = options or site.Options()
        self._made: Mapping[str, bytes] = {}
        self._files: dict[str, tuple[object, _File]] = {}  # by key, with what the file was made of
        self._checked = float("-inf")
        self._checking: asyncio.Lock | None = None

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["method"] not in ("GET", "HEAD"):
            await PlainTextResponse("Method Not Allowed", 405, {"allow": "GET, HEAD"})(scope, receive, send)
            return
        key = scope["path"].removeprefix("/")
        response = self._generated(key)
        if response is None:
            try:
                await self._refresh(key)
            except (site.SiteError, SdkError) as error:
                response = PlainTextResponse(str(error), 500)
            else:
                found = self._find(key)
                if isinstance(found, _File):
                    await _send(found, scope, send)
                    return
                response = found or self._missing(key)
                if found is not None:
                    query = scope["query_string"].decode("latin-1")
                    response.headers["location"] += query and f"?{query}"
        await response(scope, receive, send)

    def warm(self) -> None:
        """Make the pages now."""
        self._made = site.made_files(self._folder, self._options)
        self._checked = time.monotonic()

    async def _refresh(self, key: str) -> None:
        is_page = not key or key.endswith(("/", ".html")) or "." not in key
        if self._made and (not is_page or time.monotonic() < self._checked + CHECK_INTERVAL_S):
            return
        self._checked = time.monotonic() if self._made else self._checked
        made = await asyncio.get_running_loop().run_in_executor(
            None, site.made_files, self._folder, self._options
        )
        self._made, self._checked = made, time.monotonic()

    def _find(self, key: str) -> _File | Response | None:
        made = f"{key}index.html" if not key or key.endswith("/") else key
        content = self._made.get(made)
        if content is not None:
            return self._file(made, content, content)
        path = (self._folder / made).resolve()
        if self._folder not in path.parents:
            return None
        if f"{key}/index.html" in self._made or (path / "index.html").is_file():
            return RedirectResponse(f"/{key}/")
        if not path.is_file():
            return None
        status = path.stat()
        state = status.st_mtime_ns, status.st_size
        known = self._files.get(made)
        if known is not None and known[0] == state:
            return known[1]
        return self._file(made, state, path.read_bytes())

    def _file(self, key: str, state: object, content: bytes) -> _File:
        known = self._files.get(key)
        if known is None or known[0] is not state:
            known = self._files[key] = state, _file(key, content)
        return known[1]

    def _missing(self, key: str) -> Response:
        """Return the page of what is missing, as at the edge; files do without."""
        is_file = "." in key.rpartition("/")[2] and not key.endswith(".html")
        if is_file or "404.html" not in self._made:
            return PlainTextResponse("Not Found", 404)
        return Response(self._made["404.html"], 404, headers("404.html"), "text/html")

    def _generated(self, key: str) -> Response | None:
        """Return a file that a deployment uploads next to the client's."""
        address, contact = self._options.origin, self._settings.get("operator", {}).get("contact", "")
        match key:
            case "config.json":
                # The SDK reads it from pages of other origins.
                return JSONResponse(self._settings, headers=_NO_CACHE | FOR_EVERYONE)
            case "shell.json":
                return JSONResponse(shell(self._folder, self._options), headers=_NO_CACHE)
            case "robots.txt":
                return Response(robots_text(address), headers=_NO_CACHE, media_type="text/plain")
            case "sitemap.xml":
                pages = site.page_keys(self._folder)
                return Response(sitemap(address, pages), headers=_NO_CACHE, media_type="application/xml")
            case ".well-known/security.txt" if contact:
                content = security_text(contact, datetime.now(UTC), address)
                return Response(content, headers=_NO_CACHE, media_type="text/plain")
        return None


def _file(key: str, content: bytes) -> _File:
    tag = f'"{hashlib.sha256(content).hexdigest()[:24]}"'
    described = headers(key) | {"content-type": media_type(key), "etag": tag}
    if f"/{key}".startswith(SHARED):
        described |= FOR_EVERYONE
    compressed = None
    if Path(key).suffix in _COMPRESSIBLE and 500 <= len(content) <= _MAX_COMPRESSED_BYTES:
        described["vary"] = "accept-encoding"
        small = gzip.compress(content, 6, mtime=0)
        compressed = small, _raw(described | {"content-encoding": "gzip"}, small)
    return _File(content, _raw(described, content), tag.encode(), compressed)


def _raw(described: Mapping[str, str], content: bytes) -> list[tuple[bytes, bytes]]:
    all_headers = {**described, "content-length": str(len(content))}
    return [(name.encode(), value.encode()) for name, value in all_headers.items()]


async def _send(file: _File, scope: Scope, send: Send) -> None:
    content, own = file.content, file.headers
    for name, value in scope["headers"]:
        if name == b"if-none-match" and file.tag in value:
            kept = [header for header in own if header[0] not in (b"content-length", b"content-type")]
            await send({"type": "http.response.start", "status": 304, "headers": kept})
            await send({"type": "http.response.body", "body": b""})
            return
        if name == b"accept-encoding" and file.compressed is not None and b"gzip" in value:
            content, own = file.compressed
    await send({"type": "http.response.start", "status": 200, "headers": own})
    await send({"type": "http.response.body", "body": b"" if scope["method"] == "HEAD" else content})


class _Objects(Protocol):
    """Objects that everyone may read."""

    def get_version(self, name: str) -> tuple[bytes, str] | None: ...

    def headers(self, name: str) -> tuple[str, str | None]: ...


class PublicObjects:
    """ASGI application of the public dumps: GET and HEAD."""

    def __init__(self, objects: _Objects) -> None:
        self._objects = objects

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        response = await asyncio.get_running_loop().run_in_executor(None, self._answer, scope)
        await response(scope, receive, send)

    def _answer(self, scope: Scope) -> Response:
        if scope["method"] not in ("GET", "HEAD"):
            return Response(status_code=405, headers={"allow": "GET, HEAD"})
        name = scope["path"].removeprefix("/")
        found = self._objects.get_version(name)
        described = FOR_EVERYONE | {"x-content-type-options": "nosniff"}
        if found is None:
            return Response(status_code=404, headers=described | {"cache-control": "public, max-age=10"})
        content, tag = found
        kind, cache_control = self._objects.headers(name)
        described |= {"etag": f'"{tag}"', "cache-control": cache_control or "no-cache"}
        if Headers(scope=scope).get("if-none-match") == f'"{tag}"':
            return Response(status_code=304, headers=described)
        return Response(content, 200, described, kind)


def media_type(path: str) -> str:
    """Return the content type of a file by its name."""
    kind = (
        _TYPES.get(Path(path).suffix.lower()) or mimetypes.guess_type(path)[0] or "application/octet-stream"
    )
    return f"{kind}; charset=utf-8" if kind.startswith("text/") else kind


def headers(path: str) -> dict[str, str]:
    """Return the headers that a file is served with, besides those about its content."""
    return {
        # A file may have changed with the next save: ask each time, mostly to hear 304.
        "cache-control": FOREVER if VERSIONED.match(path) else "no-cache",
        "content-security-policy": "; ".join(f"{name} {value}" for name, value in _POLICY.items()),
        "cross-origin-opener-policy": "same-origin",
        "referrer-policy": "strict-origin-when-cross-origin",
        "x-content-type-options": "nosniff",
    }


def public_settings(api: str, token: str, parameters: Mapping[str, str] | None = None) -> dict[str, Any]:
    """Content of `/config.json`, which a deployment writes; `parameters`: of the deployment."""
    settings: dict[str, Any] = {"api": api, "token": token}
    found = operator(parameters or {})
    return settings | ({"operator": found} if found else {})


def operator(parameters: Mapping[str, str]) -> dict[str, str]:
    """Name the operator of the service as far as the deployment does: `name`, `contact`, `imprint`."""
    names = {"name": "OperatorName", "contact": "OperatorContact", "imprint": "Imprint"}
    return {key: parameters[name] for key, name in names.items() if parameters.get(name)}


def contacts(parameters: Mapping[str, str]) -> dict[str, str]:
    """Return the addresses that every page's footer names: `contact`, `imprint`."""
    found = operator(parameters)
    imprint = found.get("imprint", "")
    addresses = {"contact": found.get("contact", "")}
    addresses["imprint"] = imprint if imprint.startswith("https://") else "/privacy/#imprint" if found else ""
    return {name: address for name, address in addresses.items() if address}
