"""The account is asked, before anything is made, why a deployment would fail; each answer says what to do."""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any
from unittest.mock import Mock

import boto3
import pytest
from botocore.exceptions import ClientError
from botocore.validate import ParamValidator

from infra.deploy import account_check
from infra.deploy.aws import Account
from infra.deploy.steps import Target

DOMAIN = {
    "DomainName": "calib.example.org",
    "CertificateArn": "arn:aws:acm:us-east-1:123456789012:certificate/1",
}
CERTIFICATE = {
    "Status": "ISSUED",
    "DomainName": "*.example.org",
    "SubjectAlternativeNames": ["*.example.org"],
}
TARGET = Target("mine", "us-east-1", {"SubmitConcurrency": "50", "RefitConcurrency": "20"})


def refusal(code: str, text: str = "") -> ClientError:
    return ClientError({"Error": {"Code": code, "Message": text}}, "Call")


ABSENT = refusal("NoSuchOriginAccessControl", "The specified origin access control does not exist.")


def found(
    target: Target = TARGET,
    *,
    status: str | None = None,
    parameters: Mapping[str, str] = MappingProxyType({}),
    limit: int = 1000,
    unreserved: int = 1000,
    distribution: ClientError = ABSENT,
    certificate: Any = CERTIFICATE,
    zone: str = "example.org.",
) -> list[str]:
    """Problems of an account with these responses."""
    kept = [{"ParameterKey": name, "ParameterValue": value} for name, value in parameters.items()]
    stack = {"Stacks": [{"StackStatus": status, "Parameters": kept}]}
    limits = {"ConcurrentExecutions": limit, "UnreservedConcurrentExecutions": unreserved}
    described = certificate if isinstance(certificate, ClientError) else {"Certificate": certificate}
    cloud = Mock()  # all services
    cloud.describe_stacks.side_effect = [stack if status else refusal("ValidationError")]
    cloud.get_account_settings.return_value = {"AccountLimit": limits}
    cloud.create_distribution.side_effect = distribution
    cloud.describe_certificate.side_effect = [described]
    cloud.get_hosted_zone.return_value = {"HostedZone": {"Name": zone}}
    services = ("cloudformation", "lambda", "cloudfront", "acm", "route53")
    account = Account("mine", "us-east-1", dict.fromkeys(services, cloud))
    return list(account_check.problems(target, account))


def with_parameters(**parameters: str) -> Target:
    return replace(TARGET, parameters={**TARGET.parameters, **parameters})


def test_ordinary_account_has_no_problem() -> None:
    assert found() == []
    assert found(with_parameters(**DOMAIN, HostedZoneId="Z1")) == []
    for status in ("UPDATE_ROLLBACK_COMPLETE", "REVIEW_IN_PROGRESS"):
        assert found(status=status) == []


@pytest.mark.parametrize(
    ("status", "advice"),
    [
        ("ROLLBACK_COMPLETE", "delete-stack --stack-name mine"),
        ("DELETE_FAILED", "delete-stack --stack-name mine"),
        ("UPDATE_ROLLBACK_FAILED", "continue-update-rollback --stack-name mine"),
        ("UPDATE_IN_PROGRESS", "wait until"),
    ],
)
def test_stack_that_no_deployment_can_change_is_named(status: str, advice: str) -> None:
    (problem,) = found(status=status)
    assert status in problem
    assert advice in problem


@pytest.mark.parametrize(("limit", "problems"), [(379, 1), (380, 0)])
def test_reserved_concurrency_leaves_a_hundred(limit: int, problems: int) -> None:
    complaints = found(limit=limit, unreserved=limit)
    assert len(complaints) == problems
    for complaint in complaints:
        assert f"{limit} concurrent executions" in complaint
        assert "SubmitConcurrency=0 RefitConcurrency=0" in complaint
    # What the stack has reserved already is its own.
    others = {"LookupConcurrency": "100", "PoseConcurrency": "50", "ComputeConcurrency": "20"}
    kept = {**TARGET.parameters, **others}
    assert found(status="CREATE_COMPLETE", parameters=kept, limit=270, unreserved=100) == []
    none = with_parameters(**dict.fromkeys(account_check.RESERVED, "0"))
    assert found(none, limit=10, unreserved=10) == []


def test_account_that_cloudfront_does_not_serve_yet_is_told_so() -> None:
    text = "Your account must be verified before you can add new CloudFront resources."
    (problem,) = found(distribution=refusal("AccessDenied", text))
    assert "support case" in problem
    # An operator who may not make distributions by hand is not that.
    assert found(distribution=refusal("AccessDenied", "not authorized to perform")) == []
    assert found(replace(TARGET, exists=True), status="CREATE_COMPLETE") == []


@pytest.mark.parametrize(
    ("parameters", "answers", "words"),
    [
        ({"CertificateArn": ""}, {}, "needs CertificateArn"),
        (
            {"CertificateArn": "arn:aws:acm:eu-central-1:123456789012:certificate/1"},
            {},
            "only certificates of us-east-1",
        ),
        ({}, {"certificate": {**CERTIFICATE, "Status": "PENDING_VALIDATION"}}, "PENDING_VALIDATION"),
        ({"DomainName": "calib.other.org"}, {}, "request one that names calib.other.org"),
        ({}, {"certificate": refusal("ResourceNotFoundException")}, "cannot be read"),
        ({"HostedZoneId": "Z1"}, {"zone": "other.org."}, "pass the zone of that domain"),
    ],
)
def test_certificate_and_zone_fit_the_domain(
    parameters: dict[str, str], answers: dict[str, Any], words: str
) -> None:
    (problem,) = found(with_parameters(**{**DOMAIN, **parameters}), **answers)
    assert words in problem


def test_impossible_distribution_is_a_request_that_the_client_sends() -> None:
    """A malformed one would fail on this machine, and say nothing of the account."""
    client = boto3.client("cloudfront", "us-east-1", aws_access_key_id="x", aws_secret_access_key="x")
    shape = client.meta.service_model.operation_model("CreateDistribution").input_shape
    asked = {"DistributionConfig": account_check.IMPOSSIBLE}
    assert not ParamValidator().validate(asked, shape).has_errors()
    behaviour = account_check.IMPOSSIBLE["DefaultCacheBehavior"]
    origins = {origin["Id"] for origin in account_check.IMPOSSIBLE["Origins"]["Items"]}
    assert behaviour["TargetOriginId"] not in origins


def test_a_failed_creation_says_what_to_do() -> None:
    reasons = [
        "Distribution: Your account must be verified before you can add new CloudFront resources.",
        "Table: something else",
    ]
    verified, other = account_check.explain(reasons)
    assert "support case" in verified
    assert other == reasons[1]
