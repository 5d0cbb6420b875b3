"""The static site: its files with ETags, compressed where that helps, and the headers of a deployment."""

from __future__ import annotations

import asyncio
import hashlib
import re
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from starlette.datastructures import Headers, QueryParams
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import Receive, Scope, Send

from calibdb.store.dumps import JSON, NO_STATISTICS, STATISTICS
from calibdb.store.sqlite import SqliteObjects
from infra.web_build import site
from infra.web_build.root_files import root_file
from infra.web_build.sdk import SiteError
from infra.web_build.site_headers import FOR_EVERYONE, compress, headers, media_type

CHECK_INTERVAL_S = 1.0
_RESULT = re.compile("([a-z]{2}/)?result/")
_MAX_COMPRESSED_BYTES = 2_000_000  # more would take too long for a request


@dataclass(frozen=True)
class _File:
    """A file in memory, as it is sent."""

    content: bytes
    compressed: bytes | None
    headers: dict[str, str]

    @classmethod
    def of(cls, key: str, content: bytes, compressed: bytes | None = None) -> _File:
        if compressed is None and len(content) <= _MAX_COMPRESSED_BYTES:
            compressed = compress(key, content)
        described = headers(key) | {
            "content-type": media_type(key),
            "etag": f'"{hashlib.sha256(content).hexdigest()[:24]}"',
        }
        return cls(content, compressed, described | ({"vary": "accept-encoding"} if compressed else {}))

    def response(self, asked: Headers) -> Response:
        if self.headers["etag"] in asked.get("if-none-match", ""):
            unchanged = {name: value for name, value in self.headers.items() if name != "content-type"}
            return Response(None, 304, unchanged)
        if self.compressed is not None and "gzip" in asked.get("accept-encoding", ""):
            return Response(self.compressed, 200, self.headers | {"content-encoding": "gzip"})
        return Response(self.content, 200, self.headers)


class Pages:
    """ASGI application of the site: GET and HEAD of the pages and files, `index.html` for folders.

    Pages are made again when one of their sources has changed, which is checked at most once per
    `CHECK_INTERVAL_S`. `settings`: content of `/config.json`. `with_head` is called in a thread with a
    result's page and `calibration_id`, and returns the page with its title.
    """

    def __init__(
        self,
        folder: Path,
        settings: Mapping[str, Any],
        options: site.Options | None = None,
        with_head: Callable[..., str] = lambda page, **_: page,
    ) -> None:
        self._folder = folder.resolve()
        self._settings = settings
        self._options = options or site.Options()
        self._with_head = with_head
        self._made: Mapping[str, bytes] = {}
        self._files: dict[str, tuple[object, _File]] = {}  # by key, with what the file was made of
        self._checked = float("-inf")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["method"] not in ("GET", "HEAD"):
            await PlainTextResponse("Method Not Allowed", 405, {"allow": "GET, HEAD"})(scope, receive, send)
            return
        key = scope["path"].removeprefix("/")
        try:
            content = root_file(key, self._folder, self._options, self._settings)
            if content is None:
                await self._refresh(key)
        except SiteError as error:
            await PlainTextResponse(str(error), 500)(scope, receive, send)
            return
        page = (
            self._find(key, scope["query_string"].decode("latin-1"))
            if content is None
            else _File.of(key, content)
        )
        if isinstance(page, _File):
            if _RESULT.fullmatch(key) and (shared := QueryParams(scope["query_string"]).get("id")):
                head = await asyncio.to_thread(self._with_head, page.content.decode(), calibration_id=shared)
                page = _File.of(f"{key}index.html", head.encode())
            response = page.response(Headers(scope=scope))
        else:
            response = page or self._missing(key)
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
        await asyncio.to_thread(self.warm)

    def _find(self, key: str, query: str) -> _File | Response | None:
        made = f"{key}index.html" if not key or key.endswith("/") else key
        content = self._made.get(made)
        if content is not None:
            return self._file(made, content, content, self._made.get(f"{made}.gz"))
        path = self._folder / made
        try:
            path = path.resolve()
            if self._folder not in path.parents:
                return None
            if path.relative_to(self._folder).parts[0] in site.SOURCE_FOLDERS:
                return None
            is_folder = f"{key}/index.html" in self._made or (path / "index.html").is_file()
            is_file = path.is_file()
        except (OSError, ValueError):  # no file can have this name
            return None
        if is_folder:
            return RedirectResponse(f"/{key}/{query and f'?{query}'}")
        if not is_file:
            return None
        status = path.stat()
        state = status.st_mtime_ns, status.st_size
        file = self._files.get(made)
        if file is not None and file[0] == state:
            return file[1]
        compressed = path.with_name(f"{path.name}.gz")
        return self._file(
            made, state, path.read_bytes(), compressed.read_bytes() if compressed.is_file() else None
        )

    def _file(self, key: str, state: object, content: bytes, compressed: bytes | None) -> _File:
        file = self._files.get(key)
        if file is None or file[0] is not state:
            file = self._files[key] = state, _File.of(key, content, compressed)
        return file[1]

    def _missing(self, key: str) -> Response:
        """Return the page of what is missing, as at the edge; files do without."""
        is_file = "." in key.rpartition("/")[2] and not key.endswith(".html")
        if is_file or "404.html" not in self._made:
            return PlainTextResponse("Not Found", 404)
        return Response(self._made["404.html"], 404, headers("404.html"), "text/html")


class PublicObjects:
    """ASGI application of the public dumps: GET and HEAD."""

    def __init__(self, objects: SqliteObjects) -> None:
        self._objects = objects

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        response = await asyncio.to_thread(self._answer, scope)
        await response(scope, receive, send)

    def _answer(self, scope: Scope) -> Response:
        if scope["method"] not in ("GET", "HEAD"):
            return Response(status_code=405, headers={"allow": "GET, HEAD"})
        name = scope["path"].removeprefix("/")
        described = FOR_EVERYONE | {"x-content-type-options": "nosniff"}
        if (version := self._objects.get_version(name)) is None:
            described |= {"cache-control": "public, max-age=10"}
            content, status = (NO_STATISTICS, 200) if name == STATISTICS else (b"", 404)
            return Response(content, status, described, JSON)
        content, tag = version
        kind, cache_control = self._objects.headers(name)
        described |= {"etag": f'"{tag}"', "cache-control": cache_control or "no-cache", "content-type": kind}
        return _File(content, None, described).response(Headers(scope=scope))
