"""The operator's command line: tokens, and an index that follows from the bucket alone."""

import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import boto3
import pytest

from infra.local import LocalStack
from infra.ops.__main__ import main
from tests.client import Client, Truth


@pytest.fixture(scope="module")
def data_dir(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A stack's folder in which a camera was calibrated three times."""
    folder = tmp_path_factory.mktemp("ops") / "data"
    with LocalStack(folder) as stack:
        for seed in range(3):
            Truth(seed=seed).calibrate(Client(stack))
    return folder


@pytest.fixture(autouse=True)
def on_it(data_dir: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DATA_DIR", str(data_dir))


@pytest.fixture
def stack(data_dir: Path) -> Iterator[LocalStack]:
    with LocalStack(data_dir) as running:
        yield running


def cameras(stack: LocalStack) -> dict[tuple[str, str], Any]:
    items = boto3.client("dynamodb").scan(TableName=stack.environment["TABLE_NAME"])["Items"]
    return {
        (item["pk"]["S"], item["sk"]["S"]): item for item in items if item["pk"]["S"].startswith("CAMERA#")
    }


def remove(stack: LocalStack, key: tuple[str, str]) -> None:
    boto3.client("dynamodb").delete_item(
        TableName=stack.environment["TABLE_NAME"], Key={"pk": {"S": key[0]}, "sk": {"S": key[1]}}
    )


def test_a_token_is_issued_listed_and_revoked(data_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["token", "create", "--origin", "https://page.example", "--plan", "page"]) == 0
    token = capsys.readouterr().out.strip()
    assert re.fullmatch(r"cdb_[0-9a-f]{16}_[0-9a-f]{48}", token)
    _, token_id, secret = token.split("_")
    assert main(["token", "list"]) == 0
    listed = capsys.readouterr().out
    assert f"{token_id}  {time.strftime('%Y-%m-%d', time.gmtime())}  page  https://page.example\n" in listed
    assert secret not in listed
    with LocalStack(data_dir) as stack:
        client = Client(stack)
        page, other = {"origin": "https://page.example"}, {"origin": "https://other.example"}
        assert client.call("POST", "/v1/auth", token=token, headers=page).status == 201
        assert client.call("POST", "/v1/auth", token=token, headers=other).status == 403
    assert main(["token", "revoke", token_id]) == 0
    with LocalStack(data_dir) as stack:
        assert Client(stack).call("POST", "/v1/auth", token=token, headers=page).status == 403


@pytest.mark.parametrize(
    "origin",
    [
        "page.example",
        "https://page.example/",
        "https://Page.example",
        "ftp://page.example",
        "https://u@page.example",
    ],
)
def test_only_origins_are_origins(origin: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["token", "create", "--origin", origin]) == 1
    answer = capsys.readouterr()
    assert origin in answer.err
    assert answer.out == ""


def test_an_unknown_token_cannot_be_revoked(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["token", "revoke", "nobody"]) == 1
    assert "no token nobody" in capsys.readouterr().err


def test_the_index_follows_from_the_bucket(data_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with LocalStack(data_dir) as stack:
        before = cameras(stack)
        for key in before:
            remove(stack, key)
        assert cameras(stack) == {}
    assert sorted(sk.split("#")[0] for _, sk in before) == ["CALIBRATION"] * 3 + ["CONSENSUS"] * 2
    for _ in range(2):  # the second time changes nothing
        assert main(["reindex"]) == 0
        assert "3 calibrations indexed, 2 consensuses computed, 0 stale" in capsys.readouterr().out
        with LocalStack(data_dir) as stack:
            assert cameras(stack) == before


def test_what_is_not_in_the_bucket_leaves_the_index(
    data_dir: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with LocalStack(data_dir) as stack:
        before = cameras(stack)
        files, bucket = boto3.client("s3"), stack.environment["BUCKET_NAME"]
        listed = files.list_objects_v2(Bucket=bucket, Prefix="calibrations/")["Contents"]
        newest = max(entry["Key"] for entry in listed)
        kept = files.get_object(Bucket=bucket, Key=newest)["Body"].read()
        files.delete_object(Bucket=bucket, Key=newest)
    assert main(["reindex"]) == 0
    assert (
        "2 calibrations indexed, 2 consensuses computed, 3 stale entries removed" in capsys.readouterr().out
    )
    with LocalStack(data_dir) as stack:
        after = cameras(stack)
        assert set(before) - set(after) == {key for key in before if newest.split("/")[2][:-5] in key[1]}
        totals = {key[1].split("#")[-1]: item["total"]["N"] for key, item in after.items() if "total" in item}
        assert totals == {"rectilinear": "2", "fisheye": "2"}
        boto3.client("s3").put_object(Bucket=bucket, Key=newest, Body=kept)
    assert main(["reindex"]) == 0
    with LocalStack(data_dir) as stack:
        assert cameras(stack) == before


def test_storage_elsewhere_must_be_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("CALIBDB_STORAGE", "aws")
    assert main(["token", "list"]) == 1
    assert "TABLE_NAME and BUCKET_NAME do not say where" in capsys.readouterr().err


def test_the_folder_of_a_running_stack_is_left_alone(
    stack: LocalStack, capsys: pytest.CaptureFixture[str]
) -> None:
    assert stack.storage is not None
    assert main(["token", "list"]) == 1
    assert "in use by another process" in capsys.readouterr().err
