"""Metrics in CloudWatch's embedded format, written only on AWS."""

import json
import re
from typing import Any

import pytest

from calibdb.http.metrics import UNITS, document
from infra.server.server import Server
from tests.helpers.data import ROOT
from tests.helpers.service.client import BRIEF, CAMERA, Client, Truth

JOBS = False


def counted(capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines() if line.startswith('{"_aws"')]
    for line in lines:
        for described in line["_aws"]["CloudWatchMetrics"]:
            assert described["Namespace"] == "calibDB"
            for dimensions in described["Dimensions"]:
                assert set(dimensions) <= set(line)
            assert all(isinstance(line[metric["Name"]], int | float) for metric in described["Metrics"])
    return lines


def total(lines: list[dict[str, Any]], name: str) -> float:
    return sum(line.get(name, 0) for line in lines)


@pytest.fixture
def in_lambda(client: Client, monkeypatch: pytest.MonkeyPatch) -> Client:
    monkeypatch.setenv("AWS_LAMBDA_RUNTIME_API", "127.0.0.1:9001")
    return client


def test_a_capture_and_lookups(in_lambda: Client, capsys: pytest.CaptureFixture[str]) -> None:
    state = Truth(seed=3).calibrate(in_lambda, camera="Counted", **BRIEF)
    assert in_lambda.lookup(camera="Never seen", redirect=False).status == 404
    assert in_lambda.lookup(camera="Never seen").status == 307
    lines = counted(capsys)
    views = len(state["views"])
    expected = {"Sessions": 1, "Calibrations": 1, "ViewsPerSession": views, "Errors": 0}
    expected |= {"Lookups": 2, "Misses": 2, "Redirects": 1}
    assert {name: total(lines, name) for name in expected} == expected
    assert total(lines, "Views") - total(lines, "Refusals") == views
    assert all(0 < line["FitTime"] < 5000 for line in lines if "FitTime" in line)


def test_a_repeated_start_is_one_session(in_lambda: Client, capsys: pytest.CaptureFixture[str]) -> None:
    assert in_lambda.open().status == 201
    for _ in range(2):
        assert in_lambda.call("POST", "/v1/session", CAMERA).status == 201
    assert in_lambda.call("POST", "/v1/session", {**CAMERA, "camera": "Another"}).status == 409
    assert total(counted(capsys), "Sessions") == 1


def test_refusals_by_reason(in_lambda: Client, capsys: pytest.CaptureFixture[str]) -> None:
    in_lambda.open()
    assert in_lambda.view(0, [0], [[1, 1]]).json["reason"] == "too_few_points"
    (line,) = [line for line in counted(capsys) if "Refusals" in line]
    assert line["Reason"] == "too_few_points"
    all_of_it, by_reason = line["_aws"]["CloudWatchMetrics"]
    assert {"Views", "Refusals", "FitTime"} <= {metric["Name"] for metric in all_of_it["Metrics"]}
    assert by_reason["Dimensions"] == [["Stack", "Reason"]]
    assert [metric["Name"] for metric in by_reason["Metrics"]] == ["Refusals"]


def test_only_refusals_are_counted_by_reason() -> None:
    line = json.loads(document("calibdb", 1.7e9, {"Errors": 1}, reason="internal"))
    (described,) = line["_aws"]["CloudWatchMetrics"]
    assert described["Dimensions"] == [["Stack"]]
    assert line["Reason"] == "internal"


def test_every_published_metric_is_listed() -> None:
    """`make cost` prices the listed ones."""
    published = set()
    for path in (*ROOT.glob("functions/*/app.py"), *ROOT.glob("layers/service/calibdb/**/*.py")):
        for arguments in re.findall(r"\bcount\(([^)]*)\)", path.read_text()):
            published |= set(re.findall(r"\b([A-Z]\w+)=", arguments))
    assert len(published) >= 6
    assert published <= set(UNITS)


def test_no_metrics_outside_lambda(stack: Server, capsys: pytest.CaptureFixture[str]) -> None:
    Client(stack).lookup(camera="Never seen")
    assert counted(capsys) == []
