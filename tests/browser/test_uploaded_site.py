"""The site as a deployment uploads it: pages find every file under its hashed name."""

import threading
from collections.abc import Iterator, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Response

from infra.deploy.site import Upload, uploads
from tests.helpers.data import ROOT

PATHS = (
    "/",
    "/calibrate/",
    "/de/board/",
    "/rig/",
    "/photos/",
    "/import/",
    "/developers/",
    "/examples/",
    "/ar/",
)
OF_FUNCTIONS = ("/v1/", "/dumps/", "/healthz")


class Handler(BaseHTTPRequestHandler):
    """Answers as CloudFront does: an address of a folder is its page."""

    files: Mapping[str, Upload]

    def do_GET(self) -> None:
        path = urlsplit(self.path).path.lstrip("/")
        file = self.files.get(path if path and not path.endswith("/") else f"{path}index.html")
        self.send_response(200 if file else 404)
        if file:
            self.send_header("content-type", file.content_type)
            if file.content_encoding:
                self.send_header("content-encoding", file.content_encoding)
        self.end_headers()
        self.wfile.write(file.content if file else b"")

    def log_message(self, format: str, *arguments: object) -> None:  # noqa: A002 - its name
        """Write nothing."""


@pytest.fixture(scope="module")
def site() -> Iterator[str]:
    made = {file.key: file for file in uploads(ROOT / "web", {"api": "/v1", "token": "cdb_none"})}
    handler = type("Site", (Handler,), {"files": made})
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def test_pages_find_their_files_and_raise_nothing(chromium: Browser, site: str) -> None:
    for path in PATHS:
        context = chromium.new_context(service_workers="block")
        page = context.new_page()
        missing: list[str] = []
        errors: list[str] = []
        scripts: list[str] = []

        def note(response: Response, missing: list[str] = missing, scripts: list[str] = scripts) -> None:
            there = urlsplit(response.url).path
            if response.status >= 400 and not there.startswith(OF_FUNCTIONS):
                missing.append(there)
            if there.endswith(".js"):
                scripts.append(there)

        page.on("response", note)
        page.on("pageerror", lambda error, errors=errors: errors.append(str(error)))
        page.goto(site + path, wait_until="networkidle")
        context.close()
        assert (missing, errors) == ([], []), path
        assert scripts, path
