"""Costs of an idle deployment, counted in the template."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, get_args

from calibdb.http import metrics
from calibdb.schema.session import Refusal
from infra.deploy.package import complete_template

_METRICS_OF_A_ROUTE = 6


def fixed_costs(prices: Mapping[str, Any]) -> dict[str, float]:
    """Price a month with the default parameters, without any request or the firewall, USD."""
    return {what: usd for what, usd in _items(prices) if usd > 0}


def custom_metrics() -> list[str]:
    """List the metrics that functions publish; those that are also counted by reason once for each."""
    reasoned = [
        f"{name} {reason}"
        for name in metrics.REASONED
        for reason in get_args(Refusal)
        if reason not in metrics.RARE
    ]
    return [*metrics.UNITS, *reasoned]


def firewall(prices: Mapping[str, Any]) -> float:
    """Price a month of the firewall, without any request."""
    (acl,) = (
        resource["Properties"]
        for resource in complete_template()["Resources"].values()
        if resource["Type"] == "AWS::WAFv2::WebACL"
    )
    return float(prices["web_acl_month"] + len(acl["Rules"]) * prices["web_acl_rule_month"])


def _items(prices: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    template = complete_template()
    resources = template["Resources"]
    if template["Parameters"]["Canary"]["Default"] == "off":
        resources = {name: each for name, each in resources.items() if each.get("Condition") != "CanaryOn"}
    assumed = prices["assumed"]

    def of_type(kind: str) -> dict[str, Any]:
        return {name: r["Properties"] for name, r in resources.items() if r["Type"] == kind}

    dashboards = of_type("AWS::CloudWatch::Dashboard")
    yield "dashboard", len(dashboards) * prices["dashboard_month"]
    alarms = of_type("AWS::CloudWatch::Alarm")
    for name, alarm in alarms.items():
        watched = sum("MetricStat" in metric for metric in alarm.get("Metrics", [])) or 1
        yield name, watched * prices["alarm_metric_month"]
    published = len(custom_metrics())
    yield f"{published} metrics", published * prices["metric_month"]
    for api in of_type("AWS::Serverless::HttpApi").values():
        routes = sum(
            len(function.get("Events", {})) for function in of_type("AWS::Serverless::Function").values()
        )
        detailed = api["DefaultRouteSettings"].get("DetailedMetricsEnabled", False)
        usd = routes * _METRICS_OF_A_ROUTE * prices["metric_month"] if detailed else 0.0
        yield "metrics of routes", usd
    for table in of_type("AWS::DynamoDB::Table").values():
        recovery = table["PointInTimeRecoverySpecification"]["PointInTimeRecoveryEnabled"]
        gb = prices["dynamodb_gb_month"] + recovery * prices["dynamodb_recovery_gb_month"]
        yield "index and its recovery", assumed["table_gb"] * gb
    read = assumed["hours"] * assumed["refreshes"] * assumed["secrets"]
    yield "secrets", read * prices["kms_request"]
    for function in of_type("AWS::Serverless::Function").values():
        for event in function.get("Events", {}).values():
            if event["Type"] == "SQS":
                usd = assumed["polls"] * prices["sqs_request"]
                yield "polling", usd
    if "Probe" in resources:
        once = (
            prices["event"]
            + prices["lambda_request"]
            + assumed["probe_gb_seconds"] * prices["lambda_gb_second"]
            + prices["cloudfront_request"] * 2
            + prices["http_api_request"]
            + 1.5 * prices["lambda_request"]
        )
        yield "probe", assumed["probes"] * once
