"""CloudFront's part: the static client, with the headers that a deployment gives it."""

from __future__ import annotations

import mimetypes
import os
from pathlib import Path
from typing import Any

from starlette.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

_POLICY = {
    "default-src": "'self'",
    "img-src": "'self' blob: data:",
    "media-src": "'self' blob:",
    "connect-src": "'self'",
    "script-src": "'self' 'wasm-unsafe-eval'",
    "style-src": "'self'",
    "worker-src": "'self'",
    "frame-ancestors": "'none'",
}
# OpenCV.js makes its glue functions from strings. A worker has the policy it was served with, so this stays
# in there.
_WORKER_POLICY = _POLICY | {"script-src": "'self' 'unsafe-eval' 'wasm-unsafe-eval'"}
_WORKER_SUFFIX = ".worker.js"
# What pages of other origins load: a module is always asked for with CORS, whoever asks.
SHARED = ("/sdk/", "/webxr/", "/vendor/webxr/", "/openapi.json")
FOR_EVERYONE = {"access-control-allow-origin": "*", "cross-origin-resource-policy": "cross-origin"}

# What the machine's own tables may lack or call otherwise; a browser is particular about these.
_TYPES = {
    ".js": "text/javascript",
    ".json": "application/json",
    ".mjs": "text/javascript",
    ".svg": "image/svg+xml",
    ".wasm": "application/wasm",
    ".webmanifest": "application/manifest+json",
    ".woff2": "font/woff2",
}


class Pages(StaticFiles):
    """The files of one folder and nothing outside of it, `index.html` for folders; GET and HEAD.

    Not compressed: over the loopback interface that costs more time than it saves.
    """

    def __init__(self, folder: Path):
        super().__init__(directory=folder, html=True, check_dir=False)

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


def media_type(path: str) -> str:
    """Return the content type of a file by its name."""
    kind = (
        _TYPES.get(Path(path).suffix.lower()) or mimetypes.guess_type(path)[0] or "application/octet-stream"
    )
    return f"{kind}; charset=utf-8" if kind.startswith("text/") else kind


def headers(path: str) -> dict[str, str]:
    """Return the headers that a file is served with, besides those about its content."""
    policy = _WORKER_POLICY if path.endswith(_WORKER_SUFFIX) else _POLICY
    return {
        # A file may have changed with the next save: ask each time, mostly to hear 304.
        "cache-control": "no-cache",
        "content-security-policy": "; ".join(f"{name} {value}" for name, value in policy.items()),
        "referrer-policy": "strict-origin-when-cross-origin",
        "x-content-type-options": "nosniff",
    }


def public_settings(api: str, token: str, edge_answers: str = "on") -> dict[str, Any]:
    """Content of `/config.json`; a deployment writes that file."""
    return {"api": api, "token": token, "edge_answers": edge_answers}
