"""Over real sockets: the API and the pages on one origin, with the headers and the log of a deployment."""

import socket
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import httpx
import pytest
from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

from infra.server.server import bind, serving
from tests.aws.emulator import LocalStack
from tests.aws.emulator.server import GatewayApp
from tests.helpers.service.client import until
from tests.helpers.stack.toy_stack import deploy

ECHO = """
    import json

    def handler(event, context):
        body = json.dumps({"event": event})
        return {"statusCode": 200, "headers": {"content-type": "application/json"}, "body": body,
                "cookies": ["a=1; Secure", "b=2"]}
"""

SLOW = """
    import time
    from pathlib import Path

    def handler(event, context):
        Path(event["queryStringParameters"]["begun"]).touch()
        time.sleep(0.3)
        return "done"
"""


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LocalStack]:
    place = tmp_path_factory.mktemp("pages")
    template = deploy(place, {"Echo": (ECHO, ("GET /v1/echo",)), "Slow": (SLOW, ("GET /v1/slow",))})
    web = place / "web"
    (web / "calibrate").mkdir(parents=True)
    (web / "lib").mkdir()
    (web / "index.html").write_text("<!doctype html>home")
    (web / "calibrate" / "index.html").write_text("<!doctype html>calibrate")
    (web / "lib" / "detector.worker.js").write_text("self.x = 1")
    (web / "sdk").mkdir()
    for name in (
        "sdk/calibdb.js",
        "openapi.json",
        "app.js",
        "sdk.mjs",
        "opencv.wasm",
        "icon.svg",
        "app.webmanifest",
        "font.woff2",
        "data.json",
    ):
        (web / name).write_bytes(b"\0asm" * 1000)
    (place / "outside.txt").write_text("secret")
    with LocalStack(template=template, web=web) as running:
        yield running


@pytest.fixture(scope="module")
def client(stack: LocalStack) -> Iterator[httpx.Client]:
    with stack.serve() as url, httpx.Client(base_url=url, timeout=60) as connected:
        yield connected


def test_api_and_pages_share_an_origin(client: httpx.Client, stack: LocalStack) -> None:
    assert client.get("/v1/echo").json()["event"]["headers"]["host"] == stack.url.removeprefix("http://")
    assert client.get("/").text == "<!doctype html>home"
    settings = client.get("/config.json")
    assert settings.json() == {"api": "/v1", "token": "cdb_dev_local"}
    assert client.get("/v1/nothing").json() == {"message": "Not Found"}


def test_repeated_headers_and_cookies_arrive_as_on_aws(client: httpx.Client) -> None:
    event = client.get(
        "/v1/echo", headers=[("x-many", "1"), ("x-many", "2"), ("cookie", "a=1"), ("cookie", "b=2")]
    ).json()["event"]
    assert event["headers"]["x-many"] == "1,2"
    assert event["cookies"] == ["a=1", "b=2"]
    assert event["requestContext"]["http"]["sourceIp"] == "127.0.0.1"
    cookies = client.get("/v1/echo").headers.get_list("set-cookie")
    assert cookies == ["a=1; Secure", "b=2"]
    client.cookies.clear()


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("/", "text/html; charset=utf-8"),
        ("/app.js", "text/javascript; charset=utf-8"),
        ("/sdk.mjs", "text/javascript; charset=utf-8"),
        ("/opencv.wasm", "application/wasm"),
        ("/icon.svg", "image/svg+xml"),
        ("/app.webmanifest", "application/manifest+json"),
        ("/font.woff2", "font/woff2"),
        ("/data.json", "application/json"),
    ],
)
def test_pages_have_strict_media_types(client: httpx.Client, path: str, kind: str) -> None:
    response = client.get(path)
    assert (response.status_code, response.headers["content-type"]) == (200, kind)
    assert response.headers["x-content-type-options"] == "nosniff"


def test_no_script_may_evaluate_strings(client: httpx.Client) -> None:
    page = client.get("/").headers["content-security-policy"]
    assert "script-src 'self' 'wasm-unsafe-eval';" in page
    assert "'unsafe-eval'" not in page
    for directive in ("frame-ancestors 'none'", "base-uri 'none'", "form-action 'self'", "object-src 'none'"):
        assert directive in page.split("; "), directive
    assert client.get("/").headers["cross-origin-opener-policy"] == "same-origin"
    worker = client.get("/lib/detector.worker.js").headers["content-security-policy"]
    assert worker == page


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


def test_folders_have_an_index_and_a_slash(client: httpx.Client) -> None:
    redirect = client.get("/calibrate", follow_redirects=False)
    assert redirect.status_code == 307
    assert httpx.URL(redirect.headers["location"]).path == "/calibrate/"
    assert client.get("/calibrate/").text == "<!doctype html>calibrate"


@pytest.mark.parametrize("path", ["/../outside.txt", "/%2e%2e/outside.txt", "/..%2foutside.txt", "/absent"])
def test_nothing_outside_the_folder(client: httpx.Client, path: str) -> None:
    request = client.build_request("GET", "/")
    request.url = request.url.copy_with(raw_path=path.encode())
    assert client.send(request).status_code == 404


def test_pages_are_read_only(client: httpx.Client) -> None:
    assert client.post("/index.html", content=b"x").status_code == 405
    assert client.delete("/").status_code == 405
    assert client.post("/config.json").status_code == 405


def test_the_log_has_neither_tokens_nor_people(
    client: httpx.Client, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO", "tests.aws.emulator.access")
    client.get("/v1/echo?key=cdb_dev_local", headers={"authorization": "Bearer cdb_dev_local"})

    def ours() -> list[str]:
        lines = [
            record.getMessage() for record in caplog.records if record.name == "tests.aws.emulator.access"
        ]
        return [line for line in lines if " /v1/echo" in line]

    # The line is written once the answer is sent, so another request's may come late, and ours too.
    (line,) = until(ours)
    assert line.startswith("GET /v1/echo 200 ")
    assert line.endswith(" ms")
    assert "cdb_" not in caplog.text.replace("cdb_function", "")
    assert "127.0.0.1" not in line


def test_answers_are_not_held_back_by_nagle(stack: LocalStack, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[int] = []
    made = HttpToolsProtocol.connection_made

    def watch(self: HttpToolsProtocol, transport: Any) -> None:
        made(self, transport)
        accepted = transport.get_extra_info("socket")
        seen.append(accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))

    monkeypatch.setattr(HttpToolsProtocol, "connection_made", watch)
    listener = bind("127.0.0.1", 0)
    with serving(GatewayApp(stack.gateway, stack.workers, Path(), {}), listener):
        assert (
            httpx.get(f"http://127.0.0.1:{listener.getsockname()[1]}/v1/echo", timeout=60).status_code == 200
        )
    assert seen == [1]


def test_a_request_under_way_is_finished_at_the_end(stack: LocalStack, tmp_path: Path) -> None:
    begun = tmp_path / "begun"
    listener = bind("127.0.0.1", 0)
    url = f"http://127.0.0.1:{listener.getsockname()[1]}"
    with ThreadPoolExecutor(1) as pool:
        with serving(GatewayApp(stack.gateway, stack.workers, Path(), {}), listener):
            under_way = pool.submit(httpx.get, f"{url}/v1/slow", params={"begun": str(begun)}, timeout=60)
            until(begun.exists)
        assert under_way.result().text == "done"
    with pytest.raises(httpx.ConnectError):
        httpx.get(f"{url}/v1/slow")


def test_disconnecting_client_is_no_error(stack: LocalStack, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", "tests.aws.emulator.access")
    listener = bind("127.0.0.1", 0)
    with serving(GatewayApp(stack.gateway, stack.workers, Path(), {}), listener):
        with socket.create_connection(listener.getsockname()) as gone:
            gone.sendall(b"POST /v1/echo HTTP/1.1\r\nhost: localhost\r\ncontent-length: 100\r\n\r\nhalf")
        while not caplog.records:
            time.sleep(0.005)
    assert [record.levelname for record in caplog.records] == ["INFO"]
    assert caplog.records[0].getMessage().startswith("POST /v1/echo aborted ")
