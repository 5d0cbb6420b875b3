"""The site under the hashed names of a deployment."""

import threading
from collections.abc import Iterator, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Response

from infra.deploy.site import Upload, uploads
from tests.helpers.browser.waiting import at_rest, uncaught
from tests.helpers.data import ROOT

from ..conftest import THOROUGH
from .conftest import Visitor

PATHS = (
    "/calibrate/",
    "/de/board/",
    "/",
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


def test_pages_find_their_files_and_raise_nothing(visitor: Visitor, site: str) -> None:
    page = visitor(base_url=site).new_page()
    errors = uncaught(page)
    responses: list[Response] = []
    page.on("response", lambda response: responses.append(response))
    for path in PATHS if THOROUGH else PATHS[:2]:
        responses.clear()
        with at_rest(page):
            page.goto(path)
        asked = [(urlsplit(response.url).path, response.status) for response in responses]
        missing = [there for there, status in asked if status >= 400 and not there.startswith(OF_FUNCTIONS)]
        assert (missing, errors) == ([], []), path
        assert [there for there, _ in asked if there.endswith(".js")], path
