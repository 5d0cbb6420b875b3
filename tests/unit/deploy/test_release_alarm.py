"""A release whose handlers respond with 5xx raises the alarm that rolls it back."""

import json
from typing import Any

import pytest
from starlette.responses import Response

from calibdb.errors import UnavailableError
from calibdb.http import application
from calibdb.service import Service
from tests.aws.emulator.events import Request, to_event
from tests.helpers.sam import resources

EVENT = to_event(Request("GET", "/v1/broken"), "GET /v1/broken")


def printed(capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    return [json.loads(line) for line in capsys.readouterr().out.splitlines() if line.startswith('{"_aws"')]


@pytest.mark.parametrize(
    ("error", "status"), [(KeyError("a bug"), 500), (UnavailableError("storage does not answer"), 503)]
)
def test_response_of_5xx_makes_the_metric_of_the_alarm_and_another_makes_none(
    error: Exception, status: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("AWS_LAMBDA_RUNTIME_API", "127.0.0.1:9001")
    monkeypatch.setenv("STACK_NAME", "calibdb")
    monkeypatch.setattr(application, "_service", lambda: Service)

    def broken(_: application.Call) -> Response:
        raise error

    response = application.handler(application.route("/v1/broken", GET=broken))(EVENT, None)
    assert response["statusCode"] == status  # an ordinary return, which is no error of Lambda's
    (line,) = printed(capsys)
    (metrics,) = line["_aws"]["CloudWatchMetrics"]
    alarm = resources()["ReleaseResponseAlarm"]["Properties"]
    assert metrics["Namespace"] == alarm["Namespace"]
    assert [metric["Name"] for metric in metrics["Metrics"]] == [alarm["MetricName"]]
    assert metrics["Dimensions"] == [[dimension["Name"] for dimension in alarm["Dimensions"]]]
    assert line["Stack"] == "calibdb"
    assert line[alarm["MetricName"]] == 1
    assert alarm["Threshold"] <= 5
    handler = application.handler(application.route("/v1/broken", GET=lambda _: Response(status_code=204)))
    assert handler(EVENT, None)["statusCode"] == 204
    assert printed(capsys) == []
