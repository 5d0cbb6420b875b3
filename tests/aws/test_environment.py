"""Functions see the variables they would see on AWS, and boto3 looks where it should."""

import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from textwrap import dedent

import boto3
import pytest

from infra.deploy.intrinsics import TemplateError
from tests.aws.emulator import LocalStack
from tests.helpers.stack.toy_stack import deploy

READ = """
    import boto3, os

    def handler(event, context):
        key = {"pk": {"S": "a"}, "sk": {"S": "b"}}
        item = boto3.client("dynamodb").get_item(TableName=os.environ["TABLE"], Key=key)
        return {"table": os.environ["TABLE"], "own": os.environ.get("OWN"), "found": "Item" in item}
"""


@pytest.fixture
def template(tmp_path: Path) -> Path:
    return deploy(tmp_path, {"Read": (READ, ("GET /v1/read",))})


def test_the_environment_is_the_templates_while_the_stack_runs(template: Path) -> None:
    before = dict(os.environ)
    with LocalStack(template=template, environment={"OWN": "1"}) as stack:
        assert stack.request("GET", "/v1/read").json() == {
            "table": "calibdb-things",
            "own": "1",
            "found": False,
        }
        assert os.environ["AWS_REGION"] == "us-east-1"
    assert dict(os.environ) == before


def test_a_developers_own_aws_settings_do_not_matter(template: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_PROFILE", "no-such-profile")
    monkeypatch.setenv("AWS_ENDPOINT_URL_S3", "http://127.0.0.1:1")
    monkeypatch.setenv("AWS_SESSION_TOKEN", "expired")
    monkeypatch.setenv("AWS_REGION", "eu-central-1")
    with LocalStack(template=template) as stack:
        assert stack.request("GET", "/v1/read").status == 200
        assert boto3.client("s3").list_objects_v2(Bucket="calibdb-files")["KeyCount"] == 0
    assert os.environ["AWS_PROFILE"] == "no-such-profile"


class Elsewhere(BaseHTTPRequestHandler):
    """Storage outside of this process; it writes down what it is asked."""

    asked: list[tuple[str, bytes]]

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["content-length"]))
        self.asked.append((self.headers["x-amz-target"], body))
        self.send_response(200)
        self.send_header("content-type", "application/x-amz-json-1.0")
        self.send_header("content-length", "2")
        self.end_headers()
        self.wfile.write(b"{}")

    def log_message(self, *_: object) -> None:
        """Say nothing."""


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[tuple[str, bytes]]]:
    Elsewhere.asked = []
    with ThreadingHTTPServer(("127.0.0.1", 0), Elsewhere) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{server.server_port}")
        for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
            monkeypatch.setenv(name, "other")
        monkeypatch.setenv("AWS_DEFAULT_REGION", "eu-central-1")
        yield Elsewhere.asked
        server.shutdown()
        thread.join()


def test_storage_elsewhere_is_used_and_nothing_is_made_there(
    template: Path, elsewhere: list[tuple[str, bytes]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TABLE", "production-table")
    monkeypatch.setenv("BUCKET", "production-bucket")
    with LocalStack(template=template) as stack:
        assert stack.storage is None
        assert elsewhere == []
        assert stack.request("GET", "/v1/read").json()["table"] == "production-table"
    assert [target for target, _ in elsewhere] == ["DynamoDB_20120810.GetItem"]
    assert b"production-table" in elsewhere[0][1]


@pytest.mark.usefixtures("elsewhere")
def test_storage_elsewhere_must_be_named(template: Path) -> None:
    with pytest.raises(TemplateError, match="TABLE and BUCKET do not say where"):
        LocalStack(template=template).__enter__()


def test_the_functions_compute_on_one_thread_each() -> None:
    """With more, two seconds became half a minute where other programs wanted the processors, too."""
    script = """
        import ctypes
        from pathlib import Path
        from tests.aws.emulator import LocalStack
        with LocalStack() as stack:
            stack.warm()
            import numpy  # only now: it counts the processors when it is loaded
            (library,) = Path(numpy.__file__).parents[1].glob("numpy.libs/*openblas*")
            blas = ctypes.CDLL(str(library))
            names = ("scipy_openblas_get_num_threads64_", "openblas_get_num_threads")
            print([getattr(blas, name)() for name in names if hasattr(blas, name)])
    """
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    run = subprocess.run(
        [sys.executable, "-c", dedent(script)], capture_output=True, text=True, check=False, env=environment
    )
    assert run.stdout == "[1]\n", run.stderr
