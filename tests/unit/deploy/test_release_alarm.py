"""A release whose handlers respond with 5xx raises the alarm that rolls it back."""

import json
from typing import Any

import pytest
from starlette.responses import Response

from calibdb.errors import UnavailableError
from calibdb.http import application
from calibdb.service import Service
from tests.aws.emulator.events import Request, to_event
from tests.helpers.sam import created

EVENT = to_event(Request("GET", "/v1/broken"), "GET /v1/broken")


@pytest.fixture
def in_lambda(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_LAMBDA_RUNTIME_API", "127.0.0.1:9001")
    monkeypatch.setenv("STACK_NAME", "calibdb")
    monkeypatch.setattr(application, "_service", lambda: Service)


def printed(capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    return [json.loads(line) for line in capsys.readouterr().out.splitlines() if line.startswith('{"_aws"')]


@pytest.fixture(scope="module")
def alarm() -> dict[str, Any]:
    """The alarm on a metric of this project that rolls a release back."""
    groups = [r["Properties"] for r in created().values() if r["Type"] == "AWS::CodeDeploy::DeploymentGroup"]
    watched = [created()[a["Name"]["Ref"]]["Properties"] for a in groups[0]["AlarmConfiguration"]["Alarms"]]
    (found,) = (each for each in watched if each["Namespace"] == "calibDB")
    return dict(found)


@pytest.mark.usefixtures("in_lambda")
@pytest.mark.parametrize(
    ("error", "status"), [(KeyError("a bug"), 500), (UnavailableError("storage does not answer"), 503)]
)
def test_response_of_5xx_makes_the_metric_of_the_deployment_group_s_alarm(
    error: Exception, status: int, alarm: dict[str, Any], capsys: pytest.CaptureFixture[str]
) -> None:
    def broken(_: application.Call) -> Response:
        raise error

    response = application.handler(application.route("/v1/broken", GET=broken))(EVENT, None)
    assert response["statusCode"] == status  # an ordinary return, which is no error of Lambda's
    (line,) = printed(capsys)
    (metrics,) = line["_aws"]["CloudWatchMetrics"]
    assert metrics["Namespace"] == alarm["Namespace"]
    assert [metric["Name"] for metric in metrics["Metrics"]] == [alarm["MetricName"]]
    assert metrics["Dimensions"] == [[dimension["Name"] for dimension in alarm["Dimensions"]]]
    assert line["Stack"] == "calibdb"
    assert line[alarm["MetricName"]] == 1
    assert alarm["Threshold"] <= 5


@pytest.mark.usefixtures("in_lambda")
def test_response_without_an_error_makes_no_metric(capsys: pytest.CaptureFixture[str]) -> None:
    handler = application.handler(application.route("/v1/broken", GET=lambda _: Response(status_code=204)))
    assert handler(EVENT, None)["statusCode"] == 204
    assert printed(capsys) == []
