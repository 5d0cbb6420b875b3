"""The deployment is valid as CloudFormation sees it after the SAM transform; `make lint` reads the source."""

import fnmatch
import json
import re
from typing import Any

from calibdb.compute import refits
from calibdb.store import aws, token_cache
from infra.deploy import account_check, package
from infra.server.folder import KEYPOINTS, SITE
from infra.server.server import LIFETIMES
from infra.web_build import site_headers
from tests.aws.emulator.gateway import INTEGRATION_TIMEOUT_S
from tests.helpers.data import ROOT
from tests.helpers.sam import complete, created, resources
from tests.helpers.service.iam import statements

INLINE = ("Probe", "CutoffFunction")  # functions whose code stands in the template


def functions(known: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {
        name: resource["Properties"]
        for name, resource in known.items()
        if resource["Type"] in ("AWS::Serverless::Function", "AWS::Lambda::Function") and name not in INLINE
    }


def routes() -> list[dict[str, Any]]:
    events = [e for p in functions(resources()).values() for e in p.get("Events", {}).values()]
    return [event["Properties"] for event in events if event["Type"] == "HttpApi"]


def test_role_holds_its_shared_policies_within_the_iam_limit() -> None:
    roles = {n: r["Properties"] for n, r in created().items() if r["Type"] == "AWS::IAM::Role"}
    arns = roles["RigFunctionRole"]["ManagedPolicyArns"]
    assert {"Ref": "SessionStoragePolicy"} in arns
    assert max(len(role.get("ManagedPolicyArns", ())) for role in roles.values()) == len(arns) <= 10


def test_runtime_architecture_threads_and_payload() -> None:
    # With more threads, two seconds became half a minute where other programs wanted the processors, too.
    assert complete()["Globals"]["Function"]["Environment"]["Variables"]["OPENBLAS_NUM_THREADS"] == "1"
    for name, properties in functions(created()).items():
        assert (properties["Runtime"], properties["Architectures"]) == ("python3.13", ["arm64"]), name
    (api,) = (r for r in created().values() if r["Type"] == "AWS::ApiGatewayV2::Api")
    integrations = [
        method["x-amazon-apigateway-integration"]
        for path in api["Properties"]["Body"]["paths"].values()
        for verb, method in path.items()
        if verb != "options"
    ]
    assert {integration["payloadFormatVersion"] for integration in integrations} == {"2.0"}


def test_no_statement_uses_wildcards() -> None:
    for name, properties in functions(resources()).items():
        for statement in statements(complete(), properties):
            actions = statement["Action"] if isinstance(statement["Action"], list) else [statement["Action"]]
            assert all(re.fullmatch(r"[a-z0-9]+:[A-Za-z]+", action) for action in actions), (name, actions)
            assert statement["Resource"] != "*", name
            if any(action.startswith("dynamodb:") for action in actions):
                keys = statement["Condition"]["ForAllValues:StringLike"]["dynamodb:LeadingKeys"]
                assert keys, name
                assert all(re.fullmatch(r"[A-Z]+#\*", key) for key in keys), name


def test_the_edge_serves_pages_as_the_local_stack_does() -> None:
    for name in ("PageHeaders", "WorkerHeaders"):
        config = resources()[name]["Properties"]["ResponseHeadersPolicyConfig"]
        policy = config["SecurityHeadersConfig"]["ContentSecurityPolicy"]["ContentSecurityPolicy"]
        assert policy == site_headers.headers("calibrate/main.js")["content-security-policy"]
        assert "default-src 'self'" in policy


def test_edge_caches_lookups_for_less_than_a_minute() -> None:
    """A token remembered by a function and an answer kept by the edge end in time together."""
    key = resources()["LookupCaching"]["Properties"]["CachePolicyConfig"]
    assert 0 < key["MaxTTL"] <= 60 - token_cache.TOKEN_TTL_S
    named = key["ParametersInCacheKeyAndForwardedToOrigin"]
    assert named["HeadersConfig"]["Headers"] == ["Authorization", "Origin"]
    assert named["QueryStringsConfig"]["QueryStringBehavior"] == "all"


def test_every_path_with_every_method_reaches_the_api_through_the_edge() -> None:
    behaviours = resources()["Distribution"]["Properties"]["DistributionConfig"]["CacheBehaviors"]
    patterns = [b["PathPattern"] for b in behaviours if b["TargetOriginId"] in ("api", "result")]
    paths = {event["Path"] for event in routes()}
    assert {event["Path"] for event in routes() if event["Method"] == "ANY"} == paths, "for a wrong method"
    for path in {path.removesuffix("index.html").replace("{language}", "de") for path in paths}:
        assert any(fnmatch.fnmatchcase(path, pattern) for pattern in patterns), path


def test_objects_and_items_expire_as_on_a_self_hosted_server() -> None:
    lifetimes = {}
    for bucket, name in ((KEYPOINTS, "KeypointBucket"), (SITE, "WebBucket")):
        for rule in resources()[name]["Properties"]["LifecycleConfiguration"]["Rules"]:
            if "ExpirationInDays" in rule:
                assert rule["Status"] == "Enabled"
                lifetimes[bucket, rule["Prefix"]] = 86_400 * rule["ExpirationInDays"]
    assert lifetimes == LIFETIMES, "what was given stays"
    expiry = resources()["Table"]["Properties"]["TimeToLiveSpecification"]
    assert expiry == {"AttributeName": "ttl", "Enabled": True}


def test_table_and_buckets_outlive_the_stack_and_can_be_restored() -> None:
    table = resources()["Table"]["Properties"]
    assert table["PointInTimeRecoverySpecification"]["PointInTimeRecoveryEnabled"]
    assert table["BillingMode"] == "PAY_PER_REQUEST"
    buckets = [resources()[name] for name in ("KeypointBucket", "WebBucket")]
    for resource in (resources()["Table"], *buckets):
        # A creation that fails leaves none of them behind, under a name that nobody knows.
        assert resource["DeletionPolicy"] == "RetainExceptOnCreate"
        assert resource["UpdateReplacePolicy"] == "Retain"
    for bucket in buckets:
        assert bucket["Properties"]["VersioningConfiguration"] == {"Status": "Enabled"}


def test_buckets_are_closed_encrypted_and_reached_by_tls_only() -> None:
    for name in ("KeypointBucket", "WebBucket"):
        bucket = resources()[name]["Properties"]
        assert len(bucket["PublicAccessBlockConfiguration"]) == 4
        assert all(bucket["PublicAccessBlockConfiguration"].values())
        assert bucket["BucketEncryption"]
        statements = resources()[f"{name}Policy"]["Properties"]["PolicyDocument"]["Statement"]
        (denied,) = (s for s in statements if s["Effect"] == "Deny")
        assert (denied["Principal"], denied["Action"]) == ("*", "s3:*")
        assert denied["Condition"] == {"Bool": {"aws:SecureTransport": "false"}}
        assert len(denied["Resource"]) == 2
        allowed = [s for s in statements if s["Effect"] == "Allow"]
        assert [s["Principal"] for s in allowed] == (
            [{"Service": "cloudfront.amazonaws.com"}] if name == "WebBucket" else []
        )
    web, api = resources()["Distribution"]["Properties"]["DistributionConfig"]["Origins"]
    assert web["OriginAccessControlId"] == {"Ref": "WebAccess"}
    assert api["CustomOriginConfig"]["OriginProtocolPolicy"] == "https-only"


def test_edge_compresses_cached_responses_with_brotli() -> None:
    for name in ("WebCaching", "LookupCaching"):
        key = resources()[name]["Properties"]["CachePolicyConfig"]
        assert key["ParametersInCacheKeyAndForwardedToOrigin"]["EnableAcceptEncodingBrotli"] is True, name
    config = resources()["Distribution"]["Properties"]["DistributionConfig"]
    for behaviour in (config["DefaultCacheBehavior"], *config["CacheBehaviors"]):
        assert behaviour["ViewerProtocolPolicy"] in ("https-only", "redirect-to-https")
        assert behaviour.get("Compress") or behaviour["PathPattern"] == "/healthz", behaviour


def test_access_logs_hold_neither_addresses_nor_credentials() -> None:
    written = resources()["HttpApi"]["Properties"]["AccessLogSettings"]["Format"]
    assert not [v for v in json.loads(written).values() if "message" in v.lower()], "it may contain quotes"
    variables = set(re.findall(r"\$context\.([\w.]+)", written))
    assert not variables & {"path", "identity.sourceIp", "identity.userAgent", "authorizer.principalId"}
    assert not [v for v in variables if v.startswith(("identity", "requestOverride"))]
    assert {"requestId", "routeKey", "status"} <= variables


def test_dashboard_shows_published_metrics_only() -> None:
    deployed = package.package_template(complete())
    body = json.loads(deployed["Resources"]["Dashboard"]["Properties"]["DashboardBody"]["Fn::Sub"])
    shown = set()
    for widget in body["widgets"]:
        namespace = ""
        for metric in widget["properties"]["metrics"]:
            if isinstance(metric[0], str) and metric[0] != "...":
                namespace = metric[0] if metric[0] != "." else namespace
                shown |= {metric[1]} if namespace == "calibDB" else set()
    code = "".join(
        p.read_text() for p in (*ROOT.glob("functions/*/app.py"), *ROOT.glob("layers/service/**/*.py"))
    )
    assert len(shown) >= 7
    for name in shown | {"Refusals", "Errors"}:
        assert re.search(rf"\b{name}=|\"{name}\"", code), name


def test_every_alarm_has_the_topic() -> None:
    alarms = [r["Properties"] for r in resources().values() if r["Type"] == "AWS::CloudWatch::Alarm"]
    assert len(alarms) >= 5
    for alarm in alarms:
        assert alarm["AlarmActions"][0] == {"Ref": "AlarmTopic"}
        summed = [metric for metric in alarm.get("Metrics", []) if "MetricStat" in metric]
        assert len(summed) <= 10, "CloudWatch evaluates no more"
    assert resources()["Budget"]["DependsOn"] == "AlarmTopicPolicy"
    # A probe or a canary that does not run is a failure; anything else without data is at rest.
    missing = [alarm["TreatMissingData"] for alarm in alarms]
    assert sorted(missing) == ["breaching", "breaching", *["notBreaching"] * (len(alarms) - 2)]


def test_extra_costs_are_off_by_default_but_for_the_firewall() -> None:
    defaults = {name: p["Default"] for name, p in complete()["Parameters"].items()}
    assert (defaults["EdgeLogs"], defaults["DomainName"], defaults["SnapStart"]) == ("off", "", "None")
    assert defaults["WafRate"] > 0
    assert "6 USD a month" in complete()["Parameters"]["WafRate"]["Description"]
    assert resources()["RateRule"]["Condition"] == "Firewall"
    assert complete()["Globals"]["Function"]["Tracing"] == {"Ref": "Tracing"}
    assert defaults["Tracing"] == "PassThrough"
    assert "AWS::XRay::SamplingRule" not in {r["Type"] for r in resources().values()}
    stage = resources()["HttpApi"]["Properties"]["DefaultRouteSettings"]
    assert stage["DetailedMetricsEnabled"] is False
    # Without a specification DynamoDB uses a key of its own; with one, each request of KMS costs.
    assert "SSESpecification" not in resources()["Table"]["Properties"]


def test_failed_invocations_reach_the_dead_letter_queue() -> None:
    (config,) = (r["Properties"] for r in created().values() if r["Type"] == "AWS::Lambda::EventInvokeConfig")
    assert config["FunctionName"] == {"Ref": "RefitFunction"}
    assert config["Qualifier"] == "$LATEST"
    assert config["DestinationConfig"]["OnFailure"]["Destination"] == {"Fn::GetAtt": ["RefitRetries", "Arn"]}


def test_concurrency_and_rates_are_bounded() -> None:
    (stage,) = (r["Properties"] for r in created().values() if r["Type"] == "AWS::ApiGatewayV2::Stage")
    assert set(stage["DefaultRouteSettings"]) >= {"ThrottlingRateLimit", "ThrottlingBurstLimit"}
    reserved = [
        properties["ReservedConcurrentExecutions"]["Fn::If"][1]["Ref"]
        for name, properties in functions(created()).items()
        # Everything with the solver that requests wait for, and lookups; health checks are throttled at 20/s.
        if name == "LookupFunction" or (properties["MemorySize"] == 1769 and name != "HealthFunction")
    ]
    assert {name: reserved.count(name) for name in reserved} == account_check.RESERVED


def test_flood_on_one_route_leaves_rate_to_the_others() -> None:
    defaults = {name: p["Default"] for name, p in complete()["Parameters"].items() if "Default" in p}
    api = resources()["HttpApi"]["Properties"]
    everything = defaults[api["DefaultRouteSettings"]["ThrottlingRateLimit"]["Ref"]]
    existing = {f"{route['Method']} {route['Path']}" for route in routes()}
    limited = api["RouteSettings"]
    assert set(limited) == existing  # a key without a route makes the deployment fail
    for key in (
        "POST /v1/lookup",
        "GET /v1/lookup",
        "POST /v1/auth",
        "POST /v1/session/views",
        "POST /v1/checks",
    ):
        assert 0 < defaults[limited[key]["ThrottlingRateLimit"]["Ref"]] <= 0.6 * everything, key


def test_who_waits_gives_up_after_whom_it_waits_for() -> None:
    """Refit for its turn, its caller for refit, the function for its caller's answer, the gateway for all."""
    default = complete()["Globals"]["Function"]["Timeout"]
    refit = resources()["RefitFunction"]["Properties"]["Timeout"]
    invoke = aws._INVOKE.read_timeout
    assert sum(refits.WAITS_S) < invoke < default < INTEGRATION_TIMEOUT_S
    assert invoke < refit
