"""Usage of AWS by requests, its price, and the costs of an idle deployment, counted in the template."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

from calibdb.http import metrics
from calibdb.schema.session import Refusal
from infra.deploy.package import complete_template

PRICES = Path(__file__).with_name("prices.yaml")
_GB = 1e9
_METRICS_OF_A_ROUTE = 6
_LOG_EVENTS = 2  # of a request: the gateway's access log and the function's metrics


@dataclass
class Usage:
    """Resources that some requests used.

    Attributes
    ----------
    requests, sent
        Through the gateway; bytes of their responses.
    invocations, gb_seconds
        Of all functions; billed GB-seconds.
    memory, solver_memory
        Memory of all invocations, GB: of functions without and with the solver.
    reads, writes
        DynamoDB's units.
    puts, gets, kept
        S3's requests; bytes of what lasts.
    waits
        Requests to services, and GB of the function that waits for each.
    """

    requests: int = 0
    sent: int = 0
    invocations: int = 0
    gb_seconds: float = 0.0
    memory: float = 0.0
    solver_memory: float = 0.0
    reads: float = 0.0
    writes: float = 0.0
    puts: int = 0
    gets: int = 0
    kept: int = 0
    waits: list[tuple[str, float]] = field(default_factory=list)


def price(use: Usage, prices: Mapping[str, Any]) -> dict[str, float]:
    """Price the usage; USD by kind of cost."""
    assumed = prices["assumed"]
    waited = sum(assumed[f"{service}_seconds"] * gb for service, gb in use.waits)
    started = assumed["cold_starts"] * (
        assumed["start_seconds"] * use.memory + assumed["solver_start_seconds"] * use.solver_memory
    )
    logged = use.requests * (
        assumed["access_log_bytes"] + assumed["metric_log_bytes"] + _LOG_EVENTS * assumed["log_event_bytes"]
    )
    return {
        "API": use.requests * prices["http_api_request"],
        "functions": use.invocations * prices["lambda_request"]
        + (use.gb_seconds + waited + started) * prices["lambda_gb_second"],
        "index": use.reads * prices["dynamodb_read_unit"] + use.writes * prices["dynamodb_write_unit"],
        "objects": use.puts * prices["s3_put"]
        + use.gets * prices["s3_get"]
        + use.kept / _GB * prices["s3_gb_month"] * assumed["months_kept"],
        "logs": logged / _GB * prices["log_gb"],
        "secrets": use.requests * assumed["cold_starts"] * assumed["secrets"] * prices["kms_request"],
        "transfer": use.sent / _GB * prices["transfer_gb"],
    }


def price_preflights(lookups: float, memory: float, prices: Mapping[str, Any]) -> float:
    """Price the preflights of so many lookups at the API's own address, USD.

    An HTTP API answers a preflight itself, or invokes the function of an `ANY` route: the dearer is counted.
    `memory`: GB of the function.
    """
    assumed = prices["assumed"]
    each = prices["http_api_request"] + prices["lambda_request"]
    each += assumed["preflight_seconds"] * memory * prices["lambda_gb_second"]
    each += (assumed["access_log_bytes"] + assumed["log_event_bytes"]) / _GB * prices["log_gb"]
    return float(lookups * assumed["preflights"] * each)


def price_at_edge(parts: Mapping[str, float], sent: float, prices: Mapping[str, Any]) -> tuple[float, float]:
    """Price a million requests through CloudFront; USD for cache misses and for cache hits.

    What it fetches from AWS is not paid for as transfer; what it sends is.
    """
    hit_price = 1e6 * prices["cloudfront_request"] + sent / _GB * prices["cloudfront_gb"]
    return sum(parts.values()) - parts["transfer"] + hit_price, hit_price


def read_units(size: int, *, consistent: bool) -> float:
    """Read units of a response of so many bytes.

    Source: Amazon DynamoDB developer guide, "Read and write operations".
    """
    return max(1, math.ceil(size / 4096)) * (1.0 if consistent else 0.5)


def write_units(size: int, *, together: bool) -> float:
    """Write units of an item of so many bytes; `together`: in a transaction."""
    return max(1, math.ceil(size / 1024)) * (2.0 if together else 1.0)


def custom_metrics() -> list[str]:
    """Metrics that functions publish; those that are also counted by reason, once for each."""
    reasons = [reason for reason in get_args(Refusal) if reason not in metrics.RARE]
    return [*metrics.UNITS, *(f"{name} {reason}" for name in metrics.REASONED for reason in reasons)]


def firewall(prices: Mapping[str, Any]) -> float:
    """Price a month of the firewall, without any request, USD."""
    (acl,) = of_type(complete_template()["Resources"], "AWS::WAFv2::WebACL").values()
    return float(prices["web_acl_month"] + len(acl["Rules"]) * prices["web_acl_rule_month"])


def of_type(resources: Mapping[str, Any], kind: str) -> dict[str, Any]:
    """Properties of the resources of a type, by name."""
    return {name: r["Properties"] for name, r in resources.items() if r["Type"] == kind}


def fixed_costs(prices: Mapping[str, Any]) -> dict[str, float]:
    """Price a month with the default parameters, without any request or the firewall, USD."""
    return {what: usd for what, usd in _items(prices) if usd > 0}


def _items(prices: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    template = complete_template()
    resources = template["Resources"]
    if template["Parameters"]["Canary"]["Default"] == "off":
        resources = {name: each for name, each in resources.items() if each.get("Condition") != "CanaryOn"}
    assumed = prices["assumed"]
    yield "dashboard", len(of_type(resources, "AWS::CloudWatch::Dashboard")) * prices["dashboard_month"]
    for name, alarm in of_type(resources, "AWS::CloudWatch::Alarm").items():
        watched = sum("MetricStat" in metric for metric in alarm.get("Metrics", [])) or 1
        yield name, watched * prices["alarm_metric_month"]
    published = len(custom_metrics())
    yield f"{published} metrics", published * prices["metric_month"]
    functions = of_type(resources, "AWS::Serverless::Function").values()
    events = [event for function in functions for event in function.get("Events", {}).values()]
    for api in of_type(resources, "AWS::Serverless::HttpApi").values():
        if api["DefaultRouteSettings"].get("DetailedMetricsEnabled", False):
            yield "metrics of routes", len(events) * _METRICS_OF_A_ROUTE * prices["metric_month"]
    for table in of_type(resources, "AWS::DynamoDB::Table").values():
        recovery = table["PointInTimeRecoverySpecification"]["PointInTimeRecoveryEnabled"]
        gb = prices["dynamodb_gb_month"] + recovery * prices["dynamodb_recovery_gb_month"]
        yield "index and its recovery", assumed["table_gb"] * gb
    read = assumed["hours"] * assumed["refreshes"] * assumed["secrets"]
    yield "secrets", read * prices["kms_request"]
    if any(event["Type"] == "SQS" for event in events):
        yield "polling", assumed["polls"] * prices["sqs_request"]
    if "Probe" in resources:
        once = prices["event"] + prices["http_api_request"] + 2 * prices["cloudfront_request"]
        once += 2.5 * prices["lambda_request"] + assumed["probe_gb_seconds"] * prices["lambda_gb_second"]
        yield "probe", assumed["probes"] * once
