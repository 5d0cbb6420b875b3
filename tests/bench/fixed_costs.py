"""Costs of an idle deployment, counted in the template."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

from calibdb.http import metrics
from calibdb.schema.session import Refusal
from infra.deploy.package import FRAGMENTS, ROOT, complete_template

#: files that together are the deployed template
TEMPLATES = (Path("template.yaml"), *(path.relative_to(ROOT) for path in FRAGMENTS))
_METRICS_OF_A_ROUTE = 6


@dataclass(frozen=True)
class FixedCost:
    """One item of the monthly bill; `places`: file and line of what causes it."""

    what: str
    usd: float
    places: tuple[str, ...]


def fixed_costs(prices: Mapping[str, Any]) -> list[FixedCost]:
    """Price a month of the deployment with the default parameters, without any request or the firewall."""
    return [cost for cost in _items(prices) if cost.usd > 0]


def places(*names: str) -> tuple[str, ...]:
    """Find file and line of resources; raises KeyError if there is no such resource."""
    resources = {
        match["name"]: f"{file}:{number}"
        for file in TEMPLATES
        for number, line in enumerate((ROOT / file).read_text(encoding="utf-8").splitlines(), 1)
        if (match := re.fullmatch(r"  (?P<name>\w+):", line))
    }
    return tuple(resources[name] for name in names)


def custom_metrics() -> list[str]:
    """List the metrics that functions publish; those that are also counted by reason once for each."""
    reasoned = [
        f"{name} {reason}"
        for name in metrics.REASONED
        for reason in get_args(Refusal)
        if reason not in metrics.RARE
    ]
    return [*metrics.UNITS, *reasoned]


def firewall(prices: Mapping[str, Any]) -> FixedCost:
    """Price a month of the firewall, without any request."""
    ((name, acl),) = (
        (name, resource["Properties"])
        for name, resource in complete_template()["Resources"].items()
        if resource["Type"] == "AWS::WAFv2::WebACL"
    )
    usd = prices["web_acl_month"] + len(acl["Rules"]) * prices["web_acl_rule_month"]
    return FixedCost("firewall", usd, places(name))


def _items(prices: Mapping[str, Any]) -> Iterator[FixedCost]:
    template = complete_template()
    resources = template["Resources"]
    if template["Parameters"]["Canary"]["Default"] == "off":
        resources = {name: each for name, each in resources.items() if each.get("Condition") != "CanaryOn"}
    assumed = prices["assumed"]

    def of_type(kind: str) -> dict[str, Any]:
        return {name: r["Properties"] for name, r in resources.items() if r["Type"] == kind}

    dashboards = of_type("AWS::CloudWatch::Dashboard")
    yield FixedCost("dashboard", len(dashboards) * prices["dashboard_month"], places(*dashboards))
    alarms = of_type("AWS::CloudWatch::Alarm")
    for name, alarm in alarms.items():
        watched = sum("MetricStat" in metric for metric in alarm.get("Metrics", [])) or 1
        yield FixedCost(name, watched * prices["alarm_metric_month"], places(name))
    published = len(custom_metrics())
    yield FixedCost(f"{published} metrics", published * prices["metric_month"], places("FunctionLog"))
    for name, api in of_type("AWS::Serverless::HttpApi").items():
        routes = sum(
            len(function.get("Events", {})) for function in of_type("AWS::Serverless::Function").values()
        )
        detailed = api["DefaultRouteSettings"].get("DetailedMetricsEnabled", False)
        usd = routes * _METRICS_OF_A_ROUTE * prices["metric_month"] if detailed else 0.0
        yield FixedCost("metrics of routes", usd, places(name))
    for name, table in of_type("AWS::DynamoDB::Table").items():
        recovery = table["PointInTimeRecoverySpecification"]["PointInTimeRecoveryEnabled"]
        gb = prices["dynamodb_gb_month"] + recovery * prices["dynamodb_recovery_gb_month"]
        yield FixedCost("index and its recovery", assumed["table_gb"] * gb, places(name))
    read = assumed["hours"] * assumed["refreshes"] * assumed["secrets"]
    yield FixedCost("secrets", read * prices["kms_request"], places("ReadSecretsPolicy"))
    for function in of_type("AWS::Serverless::Function").values():
        for event in function.get("Events", {}).values():
            if event["Type"] == "SQS":
                usd = assumed["polls"] * prices["sqs_request"]
                yield FixedCost("polling", usd, places(event["Properties"]["Queue"]["Fn::GetAtt"][0]))
    if "Probe" in resources:
        once = (
            prices["event"]
            + prices["lambda_request"]
            + assumed["probe_gb_seconds"] * prices["lambda_gb_second"]
            + prices["cloudfront_request"] * 2
            + prices["http_api_request"]
            + 1.5 * prices["lambda_request"]
        )
        yield FixedCost("probe", assumed["probes"] * once, places("Probe"))
