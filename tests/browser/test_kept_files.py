"""The service worker's files, the weight of pages, and the names of a deployment."""

import gzip
import hashlib
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import BrowserContext, Page, Response, Route, expect

from infra.deploy.site import uploads
from tests.helpers.browser.elsewhere import serving
from tests.helpers.browser.scripts import PLAIN
from tests.helpers.browser.waiting import at_rest, uncaught, until
from tests.helpers.marks import thorough

from ..conftest import THOROUGH
from .conftest import ROOT, Visitor

# Not localhost by name, where the network would come first; browsers take it to this machine all the same.
HOST = "pages.localhost"
HEAVIEST = 150_000  # bytes of a page, compressed, without OpenCV
MAX_REQUESTS = 50  # of the capture page, before it requests the first file of OpenCV
MAX_BYTES = 300_000  # of these files, compressed
CACHED_FILES = """async () => {
  const cache = await caches.open("calibdb");
  return (await cache.keys()).map(({ url }) => new URL(url).pathname + new URL(url).search);
}"""

VERSION = "async () => (await (await caches.match('/shell.json')).json()).version"


def kept(page: Page, *, enough: int = 20, name: str = "") -> list[str]:

    def found() -> list[str]:
        names: list[str] = page.evaluate(CACHED_FILES)
        whole = len(names) >= enough and "/shell.json" in names and any(name in each for each in names)
        return names if whole else []

    names = until(page, found)
    page.evaluate("async () => { await navigator.serviceWorker.ready; }")
    return names


def test_pages_open_offline_and_a_new_version_takes_over(visitor: Visitor, stack: str) -> None:
    context = visitor(base_url=stack.replace("127.0.0.1", HOST), service_workers="allow")
    page = context.new_page()
    page.goto("/terms/")
    found = kept(page)
    assert any(each.startswith("/calibrate/main.js?sha256=") for each in found)
    assert not [each for each in found if "/v1/" in each or "config.json" in each or "openapi" in each]
    context.set_offline(True)
    page.goto("/board/?squares=8x5")
    page.locator("#description", has_text="8 × 5").wait_for()
    page.goto("/docs/quickstart/")
    expect(page.locator("h1")).to_have_text("No connection")
    page.goto("/cameras/")
    page.locator("#status", has_text="cannot be reached").wait_for()
    context.set_offline(False)
    page.reload()
    page.locator("#status", has_text="cannot be reached").wait_for(state="hidden")
    assert not [each for each in page.evaluate(CACHED_FILES) if "/v1/" in each]

    before = kept(page)
    listed: dict[str, Any] = page.evaluate("async () => (await fetch('/shell.json')).json()")
    newer = (ROOT / "web" / "board" / "board.css").read_bytes() + b"/* newer */"
    digest = hashlib.sha256(newer).hexdigest()
    listed["version"] = "newer"
    listed["files"]["board/board.css"] = digest
    deployed = False
    logged: list[str] = []
    context.service_workers[0].on("console", lambda message: logged.append(message.text))

    def styles(route: Route) -> None:
        if deployed:
            route.fulfill(body=newer, content_type="text/css")
        else:
            route.continue_()

    context.route("**/shell.json", lambda route: route.fulfill(json=listed))
    context.route("**/board/board.css", styles)
    # The list is there before its file: nothing of it is taken up.
    page.goto(PLAIN)
    until(page, lambda: any("kept files stay as they are: board/board.css" in text for text in logged))
    assert sorted(page.evaluate(CACHED_FILES)) == sorted(before)
    deployed = True
    page.goto(PLAIN)
    found = kept(page, name=digest)
    until(page, lambda: page.evaluate(VERSION) == "newer")
    page.goto("/board/")
    assert "newer" in page.evaluate("async () => (await fetch('/board/board.css')).text()")
    assert f"/board/board.css?sha256={digest}" in found


LIGHTER = ("/", "/photos/", "/import/", "/cameras/", "/board/", "/result/?id=x")


@pytest.mark.parametrize("path", ["/calibrate/", *thorough(*LIGHTER)])
def test_pages_are_light(context: BrowserContext, path: str) -> None:
    page = context.new_page()
    begun: list[str] = []
    responses: list[Response] = []
    page.on("request", lambda request: begun.append(request.url.split("?")[0]))
    page.on("response", lambda response: responses.append(response))
    with at_rest(page):
        page.goto(path)
    sizes: dict[str, int] = {}
    for response in responses:
        name = response.url.split("?")[0]
        if not response.ok or "/vendor/opencv/" in name or "/v1/" in name or not name.startswith("http"):
            continue
        body = response.body()
        sizes[name] = len(body) if name.endswith(".woff2") else len(gzip.compress(body, 6))
    total = sum(sizes.values())
    assert total < HEAVIEST
    if path == "/calibrate/":
        detector = next(index for index, name in enumerate(begun) if "/vendor/opencv/" in name)
        early = [name for name in begun[:detector] if name.startswith("http")]
        weight = sum(sizes[name] for name in early)
        assert len(early) <= MAX_REQUESTS, early
        assert weight <= MAX_BYTES


UPLOADED = (
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


def test_pages_find_their_files_and_raise_nothing(visitor: Visitor, tmp_path: Path) -> None:
    for file in uploads(ROOT / "web", {"api": "/v1", "token": "cdb_none"}):
        path = tmp_path / file.key
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(gzip.decompress(file.content) if file.content_encoding else file.content)
    with serving(tmp_path) as site:
        visit_uploaded(visitor(base_url=site).new_page())


def visit_uploaded(page: Page) -> None:
    errors = uncaught(page)
    responses: list[Response] = []
    page.on("response", lambda response: responses.append(response))
    for path in UPLOADED if THOROUGH else UPLOADED[:2]:
        responses.clear()
        with at_rest(page):
            page.goto(path)
        asked = [(urlsplit(response.url).path, response.status) for response in responses]
        missing = [there for there, status in asked if status >= 400 and not there.startswith(OF_FUNCTIONS)]
        assert (missing, errors) == ([], []), path
        assert [there for there, _ in asked if there.endswith(".js")], path
