"""Functions see the variables they would see on AWS, and boto3 looks where it should."""

import os
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

import boto3
import pytest

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
