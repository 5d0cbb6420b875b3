"""The edge: what CloudFront is configured to do, and its functions, run as they are deployed."""

import json
import subprocess
from typing import Any

import boto3
import pytest

from calibdb.http import application
from infra.deploy.cutoff import switch
from infra.deploy.steps import Target
from infra.server import app
from tests.helpers.data import ROOT
from tests.helpers.sam import resources

# CloudFront refuses those of CORS, and those with members of their own.
CUSTOM_HEADERS = {"Cross-Origin-Opener-Policy", "Permissions-Policy", "Cross-Origin-Resource-Policy"}


def distribution() -> dict[str, Any]:
    found: dict[str, Any] = resources()["Distribution"]["Properties"]["DistributionConfig"]
    return found


def run(function: str, *requests: dict[str, Any]) -> list[Any]:
    """Answers of an edge function to viewer requests."""
    code = resources()[function]["Properties"]["FunctionCode"]
    events = [{"request": {"method": "GET", "headers": {}, "querystring": {}, **r}} for r in requests]
    script = f"{code}\nconsole.log(JSON.stringify({json.dumps(events)}.map(handler)))"
    done = subprocess.run(["node", "-e", script], capture_output=True, check=True, text=True)
    found: list[Any] = json.loads(done.stdout)
    return found


def test_no_custom_header_is_one_that_cloudfront_refuses() -> None:
    policies = [
        r["Properties"]["ResponseHeadersPolicyConfig"]
        for r in resources().values()
        if r["Type"] == "AWS::CloudFront::ResponseHeadersPolicy"
    ]
    customs = [item for policy in policies for item in policy.get("CustomHeadersConfig", {}).get("Items", [])]
    assert {item["Header"] for item in customs} == CUSTOM_HEADERS
    shared = resources()["SharedHeaders"]["Properties"]["ResponseHeadersPolicyConfig"]["CorsConfig"]
    assert shared["AccessControlAllowOrigins"] == {"Items": ["*"]}
    assert shared["AccessControlAllowCredentials"] is False
    assert shared["OriginOverride"] is True


def test_responses_of_the_edge_itself_can_be_read_by_other_origins() -> None:
    """As those of the gateway, whose headers stay where a function made the response."""
    cors = resources()["ApiHeaders"]["Properties"]["ResponseHeadersPolicyConfig"]["CorsConfig"]
    gateway = resources()["HttpApi"]["Properties"]["CorsConfiguration"]
    assert cors["AccessControlAllowOrigins"]["Items"] == gateway["AllowOrigins"]
    assert cors["AccessControlExposeHeaders"]["Items"] == gateway["ExposeHeaders"]
    assert app._EXPOSED.split(",") == gateway["ExposeHeaders"], "pages in browsers are tested with the server"
    assert cors["AccessControlAllowHeaders"]["Items"] == gateway["AllowHeaders"]
    assert cors["OriginOverride"] is False
    paths = {
        behaviour["PathPattern"]
        for behaviour in distribution()["CacheBehaviors"]
        if behaviour.get("ResponseHeadersPolicyId") == {"Ref": "ApiHeaders"}
    }
    assert paths == {"/v1/lookup", "/v1/*"}


def test_double_slash_leads_to_no_other_host() -> None:
    addresses = [
        "//evil.example/foo",
        "/\\evil.example/foo",
        "///evil.example",
        "//evil.example/",
        "/calibrate",
    ]
    for uri, answer in zip(addresses, run("WebIndex", *({"uri": uri} for uri in addresses)), strict=True):
        location = answer.get("headers", {}).get("location", {}).get("value", "/")
        assert location.startswith("/"), uri
        assert not location.startswith(("//", "/\\")), uri
        assert not answer.get("uri", "/").startswith("//"), uri


def test_folders_lead_to_their_page_and_keep_the_query() -> None:
    query = {
        "camera": {"value": "Cam%20A"},
        "tag": {"value": "1", "multiValue": [{"value": "1"}, {"value": "2"}]},
    }
    folder, bare, root, file = run(
        "WebIndex",
        {"uri": "/calibrate/"},
        {"uri": "/calibrate", "querystring": query},
        {"uri": "/"},
        {"uri": "/sdk/calibdb.js"},
    )
    uris = [folder["uri"], root["uri"], file["uri"]]
    assert uris == ["/calibrate/index.html", "/index.html", "/sdk/calibdb.js"]
    assert bare["statusCode"] == 301
    assert bare["headers"]["location"]["value"] == "/calibrate/?camera=Cam%20A&tag=1&tag=2"


def test_unknown_page_is_a_404_of_the_site_and_no_page_replaces_the_apis_errors() -> None:
    for answer in run("WebIndex", {"uri": "/nowhere"}, {"uri": "/nowhere/else/"}, {"uri": "/nowhere.html"}):
        assert answer["statusCode"] == 404
        assert answer["body"] == (ROOT / "web/404.html").read_text("utf-8")
        assert "default-src 'self'" in answer["headers"]["content-security-policy"]["value"]
    page, script = run("WebIndex", {"uri": "/calibrate/index.html"}, {"uri": "/nowhere.js"})
    assert (page["uri"], script["uri"]) == ("/calibrate/index.html", "/nowhere.js")
    # CloudFront developer guide, "Quotas on CloudFront Functions".
    assert len(resources()["WebIndex"]["Properties"]["FunctionCode"].encode()) < 10_000
    statement = resources()["WebBucketPolicy"]["Properties"]["PolicyDocument"]["Statement"][1]
    # Without the right to list, S3 answers 403 in XML for a file that is missing.
    assert set(statement["Action"]) == {"s3:GetObject", "s3:ListBucket"}
    assert {"Fn::GetAtt": ["WebBucket", "Arn"]} in statement["Resource"]
    for error in distribution()["CustomErrorResponses"]:
        assert not error.keys() & {"ResponsePagePath", "ResponseCode"}


def test_no_error_answer_is_kept_at_the_edge() -> None:
    errors = distribution()["CustomErrorResponses"]
    kept = {error["ErrorCode"]: error["ErrorCachingMinTTL"] for error in errors}
    # What is missing is no error: ten seconds, so that a camera that became known is found.
    assert kept == {404: 10, 500: 0, 502: 0, 503: 0, 504: 0}


@pytest.mark.parametrize("path", ["/known/*", "/badge/*"])
def test_answers_without_a_token_are_the_same_for_all_callers(path: str) -> None:
    (behaviour,) = (b for b in distribution()["CacheBehaviors"] if b["PathPattern"] == path)
    assert (behaviour["TargetOriginId"], behaviour["Compress"]) == ("api", True)
    assert behaviour["CachePolicyId"] == {"Ref": "AnswerCaching"}
    assert behaviour["ResponseHeadersPolicyId"] == {"Ref": "SharedHeaders"}
    assert not {"AllowedMethods", "OriginRequestPolicyId", "FunctionAssociations"} & behaviour.keys()


def test_page_of_a_result_comes_from_a_function_or_else_from_the_site() -> None:
    (group,) = distribution()["OriginGroups"]["Items"]
    assert [member["OriginId"] for member in group["Members"]["Items"]] == ["api", "web"]
    assert {429, 500, 502, 503, 504} <= set(group["FailoverCriteria"]["StatusCodes"]["Items"])
    pages = [b for b in distribution()["CacheBehaviors"] if b["TargetOriginId"] == group["Id"]]
    assert [page["PathPattern"] for page in pages] == ["/result/", "/??/result/"], "its files are the site's"
    key = resources()["ResultCaching"]["Properties"]["CachePolicyConfig"]
    named = key["ParametersInCacheKeyAndForwardedToOrigin"]["QueryStringsConfig"]
    assert named == {"QueryStringBehavior": "whitelist", "QueryStrings": ["id"]}
    for page in pages:
        assert page["ResponseHeadersPolicyId"] == {"Ref": "PageHeaders"}
        assert page["CachePolicyId"] == {"Ref": "ResultCaching"}
        assert "AllowedMethods" not in page, "a group of origins answers nothing but GET and HEAD"


def test_preflights_are_answered_at_the_edge_as_by_code() -> None:
    asked = {"access-control-request-method": {"value": "POST"}, "origin": {"value": "https://x.example"}}
    answer, plain, get = run(
        "Preflight",
        {"uri": "/v1/lookup", "method": "OPTIONS", "headers": asked},
        {"uri": "/v1/lookup", "method": "OPTIONS"},
        {"uri": "/v1/lookup", "headers": asked},
    )
    assert answer["statusCode"] == 204
    headers = {name: header["value"] for name, header in answer["headers"].items()}
    assert headers.pop("cache-control") == "no-store"
    assert headers == {name.lower(): value for name, value in application.PREFLIGHT.items()}
    assert plain["method"] == "OPTIONS"
    assert get["uri"] == "/v1/lookup"
    cors = resources()["HttpApi"]["Properties"]["CorsConfiguration"]
    assert headers["access-control-allow-methods"].split(",") == cors["AllowMethods"]
    assert headers["access-control-allow-headers"].split(",") == cors["AllowHeaders"]
    for behaviour in distribution()["CacheBehaviors"]:
        if behaviour["PathPattern"].startswith("/v1/"):
            (associated,) = behaviour["FunctionAssociations"]
            assert associated["FunctionARN"] == {"Fn::GetAtt": ["Preflight", "FunctionARN"]}
            assert "OPTIONS" in behaviour["AllowedMethods"]


def test_names_of_cloudfront_are_free_in_a_second_region() -> None:
    """They are global to the account, whatever the stack's region."""
    named = [
        n for n, r in resources().items() if r["Type"].startswith("AWS::CloudFront::") and n != "Distribution"
    ]
    assert len(named) >= 8
    assert [name for name in named if "-${AWS::Region}-" not in json.dumps(resources()[name])] == []


def test_cloudfront_sends_the_secret_of_a_named_version() -> None:
    (api,) = (o for o in distribution()["Origins"] if o["Id"] == "api")
    (header,) = api["OriginCustomHeaders"]
    assert header["HeaderValue"]["Fn::Sub"].endswith("EDGE_SECRET:${EdgeSecretVersion}}}")


def test_own_domain_gets_records_in_its_zone() -> None:
    records = resources()["DomainRecords"]
    assert records["Condition"] == "OwnZone"
    target = {"DNSName": {"Fn::GetAtt": ["Distribution", "DomainName"]}, "HostedZoneId": "Z2FDTNDATAQYW2"}
    sets = records["Properties"]["RecordSets"]
    assert [(r["Type"], r["AliasTarget"]) for r in sets] == [("A", target), ("AAAA", target)]


@pytest.mark.parametrize("metric", ["DeniedReads", "UnknownEdges"])
def test_every_counted_fault_has_an_alarm(metric: str) -> None:
    alarms = [r["Properties"] for r in resources().values() if r["Type"] == "AWS::CloudWatch::Alarm"]
    assert [a["Threshold"] > 0 for a in alarms if a.get("MetricName") == metric] == [True]


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


def test_cutoff_disables_the_distribution_once(monkeypatch: pytest.MonkeyPatch) -> None:
    cloudfront = CloudFront()
    monkeypatch.setattr(boto3, "client", {"cloudfront": cloudfront}.__getitem__)
    monkeypatch.setenv("DISTRIBUTION", "E1")
    code = resources()["CutoffFunction"]["Properties"]["Code"]["ZipFile"]
    assert len(code.encode()) <= 4096  # AWS::Lambda::Function, "ZipFile"
    module: dict[str, Any] = {}
    exec(code, module)
    for _ in range(2):
        module["handler"]({}, None)
    assert (cloudfront.config, cloudfront.tag) == ({"Enabled": False, "Comment": "kept"}, 2)


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


def test_operator_switches_the_distribution_off_and_on() -> None:
    cloudfront = CloudFront()
    for enabled, changed in ((True, False), (False, True), (False, False), (True, True)):
        assert switch(cloudfront, "E1", enabled=enabled) == changed
        assert cloudfront.config == {"Enabled": enabled, "Comment": "kept"}


def test_firewall_is_on_only_where_it_can_be_made() -> None:
    assert "WafRate" not in Target("mine", "us-east-1").effective  # the template's default
    assert Target("mine", "eu-west-1").effective["WafRate"] == "0"
    assert (
        Target("mine", "eu-west-1", {"WafRate": "2000"}).effective["WafRate"] == "2000"
    )  # refused by its rule
    block = resources()["RateRule"]["Properties"]["Rules"][0]["Action"]["Block"]["CustomResponse"]
    assert block["ResponseCode"] == 429
    assert block["ResponseHeaders"] == [{"Name": "retry-after", "Value": "300"}]
