"""The server's wheel in an environment without Node.js and this checkout, and used from there."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from calibdb import __version__
from infra.release import wheels
from tests.helpers.service.client import Client, Truth
from tests.helpers.service.remote import Remote
from tests.helpers.stack.processes import LocalProcess, environment_of, run_installed

NOT_INSTALLED = ("boto3", "botocore", "s3transfer", "jinja2", "mangum", "moto")


@pytest.fixture(scope="module")
def scripts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("server")
    wheel = wheels.build_server(root)
    assert wheel.name == f"calibdb_server-{__version__}-py3-none-any.whl"
    missing = f"import sys; sys.modules.update(dict.fromkeys({NOT_INSTALLED}))"
    return environment_of(root, wheel, startup=missing)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("data") / "calibdb"


@pytest.fixture(scope="module")
def installed(scripts: Path, data: Path) -> Iterator[Remote]:
    variables = {"PATH": str(scripts), "OPERATOR_CONTACT": "mailto:op@calibdb.example"}
    with LocalProcess(data, variables, scripts / "calibdb-server") as server, Remote(server.url) as remote:
        yield remote


def test_capture_is_guided_and_cameras_are_looked_up(installed: Remote) -> None:
    client = Client(installed)
    assert client.open().status == 201
    assert Truth(seed=1).show(client).json["accepted"]
    assert client.lookup(redirect=False).json["reason"] == "unknown_camera"


def test_pages_are_those_of_the_build(installed: Remote) -> None:
    pages = {path: installed.http.get(path) for path in ("/", "/de/board/", "/docs/api/")}
    assert {path: page.status_code for path, page in pages.items()} == dict.fromkeys(pages, 200)
    for page in pages.values():
        assert '<a href="mailto:op@calibdb.example"' in page.text
        assert ".invalid" not in page.text
    assert installed.http.get("/nothing/").status_code == 404
    assert "<html" in installed.http.get("/nothing/").text
    assert len(installed.http.get("/shell.json").json()["files"]) > 100
    assert installed.http.get("/sitemap.xml").text.count("<loc>") > 20


def test_detector_is_compressed_at_build_time(installed: Remote) -> None:
    path = "/vendor/opencv/opencv.wasm"
    with installed.http.stream("GET", path) as answer:
        assert answer.headers["content-encoding"] == "gzip"
        assert int(answer.headers["content-length"]) < 1_500_000
    plain = installed.http.get(path, headers={"accept-encoding": "identity"})
    assert "content-encoding" not in plain.headers
    assert len(plain.content) > 2_000_000, "more than a server compresses for a request"


def test_operator_acts_on_the_data_folder(installed: Remote, scripts: Path, data: Path) -> None:
    assert installed.http.get("/healthz").status_code == 200
    run_installed(scripts / "calibdb-ops", "--data", data, "publish-dump", folder=data.parent)
    assert installed.http.get("/dumps/latest.json").status_code == 200
