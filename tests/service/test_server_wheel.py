"""The server's wheel in an environment without Node.js and this checkout, and used from there."""

import os
import re
import subprocess
import sysconfig
import threading
import venv
from collections.abc import Iterator
from pathlib import Path

import pytest

from calibdb import __version__
from infra.release import wheels
from tests.helpers.service.client import Client, Truth
from tests.helpers.service.remote import Remote
from tests.helpers.stack.processes import install_wheels, without_checkout

NOT_INSTALLED = ("boto3", "botocore", "s3transfer", "mangum", "moto")
MAX_S = 120


@pytest.fixture(scope="module")
def scripts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("server")
    wheel = wheels.build_server(root)
    assert wheel.name == f"calibdb_server-{__version__}-py3-none-any.whl"
    venv.create(root / "venv", with_pip=False)
    scripts = root / "venv" / "bin"
    install_wheels(scripts / "python", wheel)
    (packages,) = (root / "venv" / "lib").glob("python*/site-packages")
    missing = f"import sys; sys.modules.update(dict.fromkeys({NOT_INSTALLED}))"
    (packages / "third-party.pth").write_text(f"{sysconfig.get_path('purelib')}\n{missing}\n")
    return scripts


def environment(scripts: Path) -> dict[str, str]:
    kept = without_checkout(os.environ)
    return kept | {"PATH": str(scripts), "OPERATOR_CONTACT": "mailto:op@calibdb.example", "PORT": "0"}


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("data")


@pytest.fixture(scope="module")
def installed(scripts: Path, data: Path) -> Iterator[Remote]:
    with (
        (data / "log").open("w") as log,
        subprocess.Popen(
            [scripts / "calibdb-server", "--data", data / "calibdb"],
            cwd=data,
            env=environment(scripts),
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        ) as process,
    ):
        watchdog = threading.Timer(MAX_S, process.kill)  # of the whole module: nothing here may hang
        watchdog.start()
        try:
            assert process.stdout
            found = re.search(r"http://127\.0\.0\.1:\d+", process.stdout.readline())
            assert found, (data / "log").read_text()[-2000:]
            with Remote(found[0]) as server:
                yield server
        finally:
            watchdog.cancel()
            process.kill()


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
    done = subprocess.run(
        [scripts / "calibdb-ops", "--data", data / "calibdb", "publish-dump"],
        cwd=data,
        env=environment(scripts),
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert installed.http.get("/dumps/latest.json").status_code == 200
