"""Over real sockets: the API and the pages on one origin, with the headers of a deployment."""

import socket
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import httpx
import pytest

from calibdb.errors import UnavailableError
from calibdb.http.part_checks import PartChecks
from infra.server import app
from infra.server.server import Server, bind, serving
from tests.helpers.service.client import until


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    place = tmp_path_factory.mktemp("pages")
    web = place / "web"
    for folder in ("calibrate", "lib", "sdk", "templates"):
        (web / folder).mkdir(parents=True)
    (web / "index.html").write_text("<!doctype html>home")
    (web / "calibrate" / "index.html").write_text("<!doctype html>calibrate")
    (web / "lib" / "detector.worker.js").write_text("self.x = 1")
    (web / "templates" / "page.html").write_text("{{ title }}")
    for name in ("sdk/calibdb.js", "openapi.json", "opencv.wasm"):
        (web / name).write_bytes(b"\0asm" * 1000)
    (place / "outside.txt").write_text("secret")
    with Server(web=web) as running:
        yield running


@pytest.fixture(scope="module")
def client(stack: Server) -> Iterator[httpx.Client]:
    with stack.serve() as url, httpx.Client(base_url=url, timeout=60) as connected:
        yield connected


def test_api_and_folders_of_pages_share_an_origin(client: httpx.Client) -> None:
    assert client.get("/healthz").json() == {"status": "ok"}
    page = client.get("/")
    assert (page.text, page.headers["content-type"]) == ("<!doctype html>home", "text/html; charset=utf-8")
    assert page.headers["x-content-type-options"] == "nosniff"
    settings = client.get("/config.json").json()
    assert (settings["api"], settings["token"]) == ("/v1", "cdb_dev_local")
    assert client.get("/calibrate/").text == "<!doctype html>calibrate"
    redirect = client.get("/calibrate", follow_redirects=False)
    assert redirect.status_code == 307
    assert httpx.URL(redirect.headers["location"]).path == "/calibrate/"


def test_no_script_may_evaluate_strings(client: httpx.Client) -> None:
    headers = client.get("/").headers
    page = headers["content-security-policy"]
    assert "script-src 'self' 'wasm-unsafe-eval';" in page
    assert "'unsafe-eval'" not in page
    for directive in ("frame-ancestors 'none'", "base-uri 'none'", "form-action 'self'", "object-src 'none'"):
        assert directive in page.split("; "), directive
    assert headers["cross-origin-opener-policy"] == "same-origin"
    assert client.get("/lib/detector.worker.js").headers["content-security-policy"] == page


def test_pages_of_other_origins_may_load_the_sdk_and_nothing_else(client: httpx.Client) -> None:
    for path in ("/sdk/calibdb.js", "/openapi.json", "/config.json"):
        headers = client.get(path, headers={"origin": "https://shop.example"}).headers
        assert headers["access-control-allow-origin"] == "*", path
        assert headers["cross-origin-resource-policy"] == "cross-origin", path
    assert "access-control-allow-origin" not in client.get("/").headers


def test_pages_are_asked_for_again_conditionally(client: httpx.Client) -> None:
    first = client.get("/opencv.wasm")
    again = client.get("/opencv.wasm", headers={"if-none-match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    assert "content-security-policy" in again.headers
    assert first.headers["cache-control"] == "no-cache"
    head = client.head("/opencv.wasm", headers={"accept-encoding": "identity"})
    assert (head.headers["content-length"], head.content) == ("4000", b"")


@pytest.mark.parametrize(
    "path",
    [
        *("/../outside.txt", "/%2e%2e/outside.txt", "/..%2foutside.txt", "/absent", "/%00"),
        *(f"/{'a' * 300}/b", "/templates/page.html", "/lib/../templates/page.html"),
    ],
)
def test_nothing_outside_the_folder_and_no_template_is_found(client: httpx.Client, path: str) -> None:
    request = client.build_request("GET", "/")
    request.url = request.url.copy_with(raw_path=path.encode())
    assert client.send(request).status_code == 404


def test_pages_are_read_only(client: httpx.Client) -> None:
    for path in ("/index.html", "/", "/config.json"):
        assert client.post(path, content=b"x").status_code == 405


def test_the_log_has_neither_tokens_nor_people(
    client: httpx.Client, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", "infra.server.access")
    client.get("/v1/lookup?key=cdb_dev_local", headers={"authorization": "Bearer cdb_dev_local"})
    # The line is written once the answer is sent.
    until(lambda: "/v1/lookup" in caplog.text)
    (line,) = (record.getMessage() for record in caplog.records if "/v1/lookup" in record.getMessage())
    assert line.startswith("GET /v1/lookup 422 ")
    assert line.endswith(" ms")
    assert "cdb_" not in caplog.text
    assert "127.0.0.1" not in line


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[threading.Event, threading.Event]]:
    """Deep health checks that begin, and wait until they are let go on."""
    begun, released = threading.Event(), threading.Event()

    def wait(_: PartChecks) -> None:
        begun.set()
        assert released.wait(60)
        raise UnavailableError("done")

    monkeypatch.setattr(PartChecks, "__call__", wait)
    yield begun, released
    released.set()


def test_a_request_under_way_is_finished_at_the_end(
    stack: Server, held: tuple[threading.Event, threading.Event]
) -> None:
    begun, released = held
    listener = bind("127.0.0.1", 0)
    url = f"http://127.0.0.1:{listener.getsockname()[1]}/healthz?deep=1"
    with ThreadPoolExecutor(1) as pool:
        with serving(stack.app, listener):
            under_way = pool.submit(httpx.get, url, timeout=60)
            assert begun.wait(60)
            threading.Timer(0.2, released.set).start()
        assert under_way.result().json()["detail"] == "done"
    with pytest.raises(httpx.ConnectError):
        httpx.get(url)


@pytest.mark.usefixtures("held")
def test_server_gives_up_on_a_slow_call(client: httpx.Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(app, "RESPONSE_TIMEOUT_S", 0.05)
    answer = client.get("/healthz?deep=1", headers={"origin": "https://page.example"})
    assert (answer.status_code, answer.json()) == (503, {"message": "Service Unavailable"})
    assert answer.headers["access-control-allow-origin"] == "*", "or the page could not read it"


def test_endless_body_is_refused(client: httpx.Client) -> None:
    def chunks() -> Iterator[bytes]:
        for _ in range(200):
            yield b"x" * 100_000

    origin = {"origin": "https://page.example"}
    answer = client.post("/v1/lookup", content=chunks(), headers=origin)
    assert (answer.status_code, answer.json()) == (413, {"message": "Request Entity Too Large"})
    assert answer.headers["access-control-allow-origin"] == "*"


def test_disconnecting_client_is_no_error(stack: Server, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", "infra.server")
    listener = bind("127.0.0.1", 0)
    with serving(stack.app, listener):
        with socket.create_connection(listener.getsockname()) as gone:
            gone.sendall(b"POST /v1/lookup HTTP/1.1\r\nhost: localhost\r\ncontent-length: 100\r\n\r\nhalf")
        until(lambda: caplog.records)
    (record,) = caplog.records
    assert (record.levelname, record.getMessage().split(" aborted ")[0]) == ("INFO", "POST /v1/lookup")
