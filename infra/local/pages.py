"""CloudFront's part: the static client, with the headers that a deployment gives it."""

from __future__ import annotations

import hashlib
import mimetypes
import os
from collections.abc import Mapping
from http import HTTPStatus
from pathlib import Path
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, PlainTextResponse, RedirectResponse, Response
from starlette.staticfiles import NotModifiedResponse, StaticFiles
from starlette.types import Scope

from infra.web_build import site
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
# What pages of other origins load: a module is always asked for with CORS, whoever asks.
SHARED = ("/sdk/", "/webxr/", "/vendor/webxr/", "/openapi.json")
FOREVER = "public, max-age=31536000, immutable"
"""Of what has a name that changes with its content."""
FOR_EVERYONE = {"access-control-allow-origin": "*", "cross-origin-resource-policy": "cross-origin"}

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


class Pages(StaticFiles):
    """The pages made of one folder, and its files, `index.html` for folders; GET and HEAD.

    Not compressed: over the loopback interface that costs more time than it saves.
    """

    def __init__(self, folder: Path, options: site.Options | None = None):
        super().__init__(directory=folder, html=True, check_dir=False)
        self._options = options
        self._folder = folder
        self._made: Mapping[str, bytes] = {}

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Answer with a file as it is made of its sources now, or as it lies there."""
        key = scope["path"].removeprefix("/")
        is_folder = not key or key.endswith("/")
        if scope["method"] not in ("GET", "HEAD"):
            return await super().get_response(path, scope)
        if is_folder or "." not in key or key.endswith(".html") or not self._made:
            # With each page, not with each of the many files it loads.
            try:
                self._made = await run_in_threadpool(site.made_files, self._folder, self._options)
            except (site.SiteError, SdkError) as error:
                return PlainTextResponse(str(error), 500)
        made = f"{key}index.html" if is_folder else key
        if made in self._made:
            return _made_response(made, self._made[made], scope)
        if f"{key}/index.html" in self._made:
            query = scope["query_string"].decode("latin-1")
            return RedirectResponse(f"/{key}/{query and '?'}{query}")
        try:
            found = await super().get_response(path, scope)
        except HTTPException as error:
            if error.status_code != HTTPStatus.NOT_FOUND or "404.html" not in self._made:
                raise
            found = Response(status_code=error.status_code)
        if found.status_code != HTTPStatus.NOT_FOUND:
            return found
        # The page of what is missing stands for pages, as at the edge.
        if "." in key.rpartition("/")[2] and not key.endswith(".html"):
            raise HTTPException(HTTPStatus.NOT_FOUND)
        return _made_response("404.html", self._made["404.html"], scope, HTTPStatus.NOT_FOUND)

    def file_response(
        self,
        full_path: str | os.PathLike[str],
        stat_result: os.stat_result,
        scope: Scope,
        status_code: int = 200,
    ) -> Response:
        """Answer with a file, or 304."""
        response = super().file_response(full_path, stat_result, scope, status_code)
        path = os.fspath(full_path)
        if isinstance(response, FileResponse):
            response.headers["content-type"] = media_type(path)
        response.headers.update(headers(path))
        if scope["path"].startswith(SHARED):
            response.headers.update(FOR_EVERYONE)
        return response


def _made_response(key: str, content: bytes, scope: Scope, status: int = HTTPStatus.OK) -> Response:
    tag = f'"{hashlib.sha256(content).hexdigest()[:24]}"'
    answer = headers(key) | {"content-type": media_type(key), "etag": tag}
    if f"/{key}".startswith(SHARED):
        answer |= FOR_EVERYONE
    if status == HTTPStatus.OK and Headers(scope=scope).get("if-none-match") == tag:
        return NotModifiedResponse(Headers(answer))
    return Response(content, status, answer)


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


def public_settings(
    api: str, token: str, edge_answers: str = "on", parameters: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Content of `/config.json`, which a deployment writes; `parameters`: of the deployment."""
    settings: dict[str, Any] = {"api": api, "token": token, "edge_answers": edge_answers}
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
    told = {"contact": found.get("contact", "")}
    told["imprint"] = imprint if imprint.startswith("https://") else "/privacy/#imprint" if found else ""
    return {name: address for name, address in told.items() if address}
