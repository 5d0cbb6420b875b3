"""Limits of what an attack costs: the switch of the distribution, and the parameters of the firewall."""

import sys
import types
from typing import Any

import pytest

from infra.deploy import aws
from infra.deploy.steps import Target
from tests.helpers.sam import resources


class CloudFront:
    """A distribution; an update needs the tag of its last one."""

    def __init__(self) -> None:
        self.config: dict[str, Any] = {"Enabled": True, "Comment": "kept"}
        self.tag = 1

    def get_distribution_config(self, **call: Any) -> Any:
        assert call == {"Id": "E1"}
        return {"ETag": str(self.tag), "DistributionConfig": dict(self.config)}

    def update_distribution(self, **call: Any) -> None:
        assert (call["Id"], call["IfMatch"]) == ("E1", str(self.tag))
        self.config, self.tag = call["DistributionConfig"], self.tag + 1


@pytest.fixture
def cloudfront() -> CloudFront:
    return CloudFront()


def test_cutoff_disables_the_distribution_once(
    cloudfront: CloudFront, monkeypatch: pytest.MonkeyPatch
) -> None:
    boto3 = types.ModuleType("boto3")
    boto3.client = {"cloudfront": cloudfront}.__getitem__  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "boto3", boto3)
    monkeypatch.setenv("DISTRIBUTION", "E1")
    code = resources()["CutoffFunction"]["Properties"]["Code"]["ZipFile"]
    assert len(code.encode()) <= 4096  # AWS::Lambda::Function, "ZipFile"
    module: dict[str, Any] = {}
    exec(code, module)
    for _ in range(2):
        module["handler"]({}, None)
    assert cloudfront.config == {"Enabled": False, "Comment": "kept"}
    assert cloudfront.tag == 2


def test_alarm_on_delivered_bytes_invokes_the_cutoff() -> None:
    alarm = resources()["CutoffAlarm"]["Properties"]
    assert alarm["AlarmActions"] == [{"Ref": "AlarmTopic"}, {"Fn::GetAtt": ["CutoffFunction", "Arn"]}]
    assert alarm["Threshold"] == {"Ref": "CutoffGigabytesAnHour"}
    watched = alarm["Metrics"][1]["MetricStat"]["Metric"]
    assert (watched["Namespace"], watched["MetricName"]) == ("AWS/CloudFront", "BytesDownloaded")
    permission = resources()["CutoffPermission"]["Properties"]
    # AWS: "Invoke a Lambda function from an alarm", CloudWatch user guide
    assert permission["Principal"] == "lambda.alarms.cloudwatch.amazonaws.com"
    assert permission["SourceArn"] == {"Fn::GetAtt": ["CutoffAlarm", "Arn"]}
    for name in ("CutoffFunction", "CutoffRole", "CutoffPermission", "CutoffAlarm"):
        assert resources()[name]["Condition"] == "CutoffOn", name


def test_operator_switches_the_distribution_off_and_on(cloudfront: CloudFront) -> None:
    assert not aws.switch(cloudfront, "E1", enabled=True)
    assert aws.switch(cloudfront, "E1", enabled=False)
    assert not aws.switch(cloudfront, "E1", enabled=False)
    assert cloudfront.config["Enabled"] is False
    assert aws.switch(cloudfront, "E1", enabled=True)
    assert cloudfront.config == {"Enabled": True, "Comment": "kept"}


def test_firewall_is_on_only_where_it_can_be_made() -> None:
    assert "WafRate" not in Target("mine", "us-east-1").effective  # the template's default
    assert Target("mine", "eu-west-1").effective["WafRate"] == "0"
    assert (
        Target("mine", "eu-west-1", {"WafRate": "2000"}).effective["WafRate"] == "2000"
    )  # refused by its rule
    block = resources()["RateRule"]["Properties"]["Rules"][0]["Action"]["Block"]["CustomResponse"]
    assert block["ResponseCode"] == 429
    assert block["ResponseHeaders"] == [{"Name": "retry-after", "Value": "300"}]
