"""The smoke test asks what pages need, and finds each thing that is missing."""

import functools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from calibdb.errors import UnavailableError
from calibdb.store import Cameras
from infra.deploy import page_token, smoke, smoke_capture
from infra.server.server import Server
from infra.web_build.site import made_files
from tests.helpers.sam import resources
from tests.helpers.service.published import store

Change = Callable[[str, str, httpx.Response], httpx.Response]


@pytest.fixture(scope="module")
def stack() -> Iterator[Server]:
    with Server() as stack:
        yield stack


@pytest.fixture(scope="module")
def address(stack: Server) -> Iterator[str]:
    made_files()  # else the first request waits for them, on a busy machine for longer than it may
    with stack.serve() as url:
        yield url


make_requester = functools.cache(smoke.make_requester)


def found(address: str, change: Change | None = None) -> list[str]:
    ask = make_requester(address)

    def changed(method: str, path: str, *sent: Any) -> httpx.Response:
        heard = ask(method, path, *sent)
        return change(method, path, heard) if change else heard

    return list(smoke.problems(changed, smoke.Site(address), patience_s=0))


def test_local_stack_passes(address: str) -> None:
    assert found(address) == []


def without(header: str, of: str) -> Change:
    def change(_: str, path: str, heard: httpx.Response) -> httpx.Response:
        if path == of:
            heard.headers.pop(header, None)
        return heard

    return change


def answering(status: int, of: tuple[str, str], **headers: str) -> Change:
    def change(method: str, path: str, heard: httpx.Response) -> httpx.Response:
        return httpx.Response(status, headers=headers) if (method, path) == of else heard

    return change


def elsewhere(_: str, __: str, heard: httpx.Response) -> httpx.Response:
    """As long as functions know the address of a release before."""
    content = heard.content.replace(b"http://127.0.0.1", b"https://calibdb.example")
    return httpx.Response(heard.status_code, content=content)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (answering(405, ("OPTIONS", "/v1/lookup")), "OPTIONS /v1/lookup: 405"),
        (without("access-control-allow-headers", "/v1/session/views"), "OPTIONS /v1/session/views: no auth"),
        (without("access-control-allow-origin", "/sdk/calibdb.js"), "GET /sdk/calibdb.js"),
        (answering(403, ("POST", "/v1/auth")), "POST /v1/auth with the pages' token"),
        (elsewhere, "POST /v1/lookup: 404, and the guidance is https://calibdb.example"),
        (
            answering(301, ("GET", "//elsewhere.example/page"), location="//elsewhere.example/page/"),
            "sent to //elsewhere.example/page/",
        ),
        (without("content-security-policy", "/calibrate/"), "no content-security-policy"),
        (answering(503, ("GET", "/healthz")), "GET /healthz: 503, not 200"),
    ],
)
def test_each_thing_that_is_missing_is_found(address: str, change: Change, complaint: str) -> None:
    assert any(complaint in problem for problem in found(address, change))


def test_site_that_cannot_be_reached_is_a_problem_and_no_trace() -> None:
    def refused(*_: object) -> httpx.Response:
        raise ConnectionRefusedError("Connection refused")

    (problem,) = smoke.problems(refused, smoke.Site("http://127.0.0.1:1"))
    assert problem == "http://127.0.0.1:1 does not answer (Connection refused)"


def test_domain_without_records_is_asked_by_the_distributions_name() -> None:
    """`.invalid` never resolves (RFC 6761)."""
    address, headers, extensions = smoke.target("https://calib.invalid", "d1.cloudfront.net")
    assert address == "https://d1.cloudfront.net"
    assert (headers, extensions) == ({"Host": "calib.invalid"}, {"sni_hostname": "calib.invalid"})
    assert smoke.target("http://127.0.0.1:1", "d1.cloudfront.net") == ("http://127.0.0.1:1", {}, {})
    site = smoke.Site("https://calib.invalid", "d1.cloudfront.net")
    complaints = list(smoke.problems(lambda *_: httpx.Response(503), site, patience_s=0))
    assert "point it to d1.cloudfront.net" in complaints[-1]


def test_function_of_another_release_is_named() -> None:
    releases = {"auth": "abc", "lookup": "abd", "refit": ""}
    assert list(smoke.unreleased(releases, "abc")) == [
        "lookup runs the release abd, not abc",
        "refit runs the release that has no name, not abc",
    ]


def test_capture_that_fails_is_a_problem(address: str, tmp_path: Path) -> None:
    (problem,) = smoke_capture.problems(smoke.Site(address), "cdb_x_y", lambda _: tmp_path.rmdir())
    assert problem.startswith("a capture: POST /v1/auth: 403")
    assert tmp_path.exists()


def test_page_token_follows_the_domain(stack: Server) -> None:
    tokens = store(stack).tokens
    site, distribution = "https://calib.example", "https://d1.cloudfront.net"
    first = page_token.admit(tokens, "", [distribution])
    again = page_token.admit(tokens, first, [distribution])
    moved = page_token.admit(tokens, first, [site, distribution])
    assert first == again == moved
    token = tokens.get(first.split("_")[1])
    assert token is not None
    assert (token.plan, set(token.origins)) == ("page", {site, distribution})
    # One that was lost with the table is made anew.
    assert page_token.admit(tokens, "cdb_0123456789abcdef_x", [site]) != first


def run_probe(url: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the code as Lambda gets it; raises RuntimeError where it finds the site out of order."""
    code = resources()["Probe"]["Properties"]["Code"]["ZipFile"]
    assert len(code) <= 4096  # AWS::Lambda::Function Code, "ZipFile": 4 MB today, 4,096 characters once
    monkeypatch.setenv("SITE_URL", url)
    names: dict[str, Any] = {}
    exec(compile(code, "index.py", "exec"), names)
    names["handler"]({}, None)


def test_probe_finds_a_site_that_answers_lookups(monkeypatch: pytest.MonkeyPatch, address: str) -> None:
    run_probe(address, monkeypatch)


def test_probe_fails_where_lookups_are_not_answered(monkeypatch: pytest.MonkeyPatch, address: str) -> None:
    def fail(*_: Any, **__: Any) -> None:
        raise UnavailableError("Storage did not answer.")

    monkeypatch.setattr(Cameras, "known", fail)
    with pytest.raises(RuntimeError, match="POST /v1/lookup: 503"):
        run_probe(address, monkeypatch)
    with pytest.raises(OSError, match="refused"):
        run_probe("http://127.0.0.1:9", monkeypatch)
