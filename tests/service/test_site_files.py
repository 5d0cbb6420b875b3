"""The local stack's site."""

import hashlib
import json
from collections.abc import Iterator

import httpx
import pytest

from infra.ops.context import OpsContext
from infra.ops.public_dump import publish_dump
from infra.server.server import Server, variables_set
from tests.helpers.service.in_process import request


@pytest.fixture(scope="module")
def site() -> Iterator[httpx.Client]:
    """The site of nobody in particular: its pages are made once for all stacks of a machine."""
    with Server() as stack, stack.serve() as url, httpx.Client(base_url=url, timeout=120) as client:
        publish_dump(OpsContext.of(stack.environment, secret_known=True))
        yield client


def test_page_of_what_is_missing_stands_for_pages_alone(site: httpx.Client) -> None:
    for path in ("/absent", "/absent/", "/de/absent/", "/absent.html"):
        page = site.get(path)
        assert (page.status_code, page.headers["content-type"]) == (404, "text/html; charset=utf-8"), path
        assert "There is no page at this address" in page.text
        assert "script-src 'self'" in page.headers["content-security-policy"]
    assert site.get("/absent.js").text == "Not Found"
    assert site.get("/v1/absent").headers["content-type"] == "application/problem+json"


def test_dumps_are_files_that_every_origin_may_read(site: httpx.Client) -> None:
    latest = site.get("/dumps/latest.json")
    assert (latest.json()["format"], latest.headers["content-type"]) == ("calibdb-dump", "application/json")
    for file in latest.json()["files"]:
        part = site.get(f"/dumps/{file['name']}")
        assert hashlib.sha256(part.content).hexdigest() == file["sha256"]
        assert part.headers["content-type"] == "application/gzip"
        assert part.headers["access-control-allow-origin"] == "*"
    assert site.get("/dumps/statistics.json").json()["history"][0]["calibrations"] == 0
    assert site.get("/dumps/draft.json").status_code == 404


def test_settings_and_security_file_say_who_runs_the_service() -> None:
    operator = {
        "OPERATOR_NAME": "Lens Society",
        "OPERATOR_CONTACT": "mailto:lens@society.example",
        "IMPRINT": "Lens Society|1 Optics Road|Exampletown",
    }
    with variables_set(operator), Server() as stack:
        settings = json.loads(request(stack, "GET", "/config.json").body)["operator"]
        security = request(stack, "GET", "/.well-known/security.txt").body.decode()
    assert list(settings.values()) == list(operator.values())
    assert f"Contact: {operator['OPERATOR_CONTACT']}" in security
