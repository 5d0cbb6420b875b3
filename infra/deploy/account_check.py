"""Check of an account: whether it can host the stack, before anything is created. It writes nothing."""

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from botocore.exceptions import ClientError

from calibdb.store.aws import code
from infra.deploy.aws import UNCREATED, Account
from infra.deploy.package import ROOT
from infra.deploy.steps import Target
from infra.deploy.template import parse

# Concurrent executions that Lambda leaves to functions without a reservation.
# Source: AWS Lambda developer guide, "Configuring reserved concurrency".
MIN_UNRESERVED = 100
# Parameter -> functions that each reserve so much
RESERVED = {
    "SubmitConcurrency": 1,
    "RefitConcurrency": 1,
    "LookupConcurrency": 1,
    "PoseConcurrency": 1,
    "ComputeConcurrency": 3,
}
_UNRESERVED = " ".join(f"{name}=0" for name in RESERVED)
_VERIFICATION = re.compile("(?i)account must be verified")
_UNVERIFIED = (
    "CloudFront does not make distributions for this account before AWS has verified it: open a support case "
    "(Account and billing, Account verification), wait for its answer, and run `make deploy` again."
)
# What CloudFormation says of a resource -> what to do
_CAUSES = (
    (_VERIFICATION, _UNVERIFIED),
    (
        re.compile("(?i)UnreservedConcurrentExecution below its minimum"),
        "Lambda has no concurrency left to reserve: ask Service Quotas for 1,000 concurrent executions "
        f"(L-B99A9384), or add {_UNRESERVED}.",
    ),
    (
        re.compile("(?i)already exists"),
        "A resource of that name is there already: deploy under another name with STACK=NAME, or delete it.",
    ),
    (
        re.compile("(?i)CNAMEAlreadyExists|One or more of the CNAMEs"),
        "Another distribution has DomainName: take the name off it first.",
    ),
)


def problems(target: Target, account: Account) -> Iterator[str]:
    """Find what would make the deployment fail."""
    stack = account.describe()
    declared = parse(ROOT / "template.yaml")["Parameters"]
    defaults = {name: str(parameter.get("Default", "")) for name, parameter in declared.items()}
    values = {**defaults, **stack.parameters, **target.parameters}
    yield from _status(target.stack, stack.status)
    yield from _concurrency(account.client("lambda"), values, stack.parameters)
    if not target.exists:
        yield from _verification(account.client("cloudfront"))
    if values["DomainName"]:
        yield from _certificate(account.client("acm"), values["DomainName"], values["CertificateArn"])
    if values["HostedZoneId"]:
        yield from _zone(account.client("route53"), values["DomainName"], values["HostedZoneId"])


def explain(reasons: Iterable[str]) -> list[str]:
    """Add to the reasons that CloudFormation gave what to do about them."""
    said = []
    for reason in reasons:
        remedy = next((remedy for pattern, remedy in _CAUSES if pattern.search(reason)), None)
        said.append(f"{reason}\n  {remedy}" if remedy else reason)
    return said


def _status(name: str, status: str) -> Iterator[str]:
    if status in ("ROLLBACK_COMPLETE", "ROLLBACK_FAILED", "CREATE_FAILED", "DELETE_FAILED"):
        yield (
            f"The stack {name} is {status}, left by a creation or deletion that failed: delete it with "
            f"`aws cloudformation delete-stack --stack-name {name}`, and run `make deploy` again."
        )
    elif status == "UPDATE_ROLLBACK_FAILED":
        yield (
            f"The stack {name} is {status}: run `aws cloudformation continue-update-rollback "
            f"--stack-name {name}`, and then `make deploy` again."
        )
    elif status.endswith("_IN_PROGRESS") and status not in UNCREATED:
        yield f"The stack {name} is {status}: wait until that has ended, and run `make deploy` again."


def _concurrency(lambda_: Any, values: Mapping[str, str], kept: Mapping[str, str]) -> Iterator[str]:
    limit = lambda_.get_account_settings()["AccountLimit"]
    reserved = sum(functions * int(values[name]) for name, functions in RESERVED.items())
    own = sum(functions * int(kept.get(name, 0)) for name, functions in RESERVED.items())
    left = int(limit["UnreservedConcurrentExecutions"]) + own - reserved
    if reserved and left < MIN_UNRESERVED:
        yield (
            f"Lambda allows this account {limit['ConcurrentExecutions']} concurrent executions; with "
            f"{reserved} reserved {left} would be left, and {MIN_UNRESERVED} must be: ask Service Quotas for "
            f"1,000 (L-B99A9384), or add {_UNRESERVED}."
        )


def _verification(cloudfront: Any) -> Iterator[str]:
    """Find out whether CloudFront serves the account, by asking for a distribution that cannot be made.

    Its origin access control does not exist, so the request always fails.
    """
    try:
        cloudfront.create_distribution(DistributionConfig=IMPOSSIBLE)
    except ClientError as error:
        if _VERIFICATION.search(str(error)):
            yield _UNVERIFIED


IMPOSSIBLE: dict[str, Any] = {
    "CallerReference": "calibdb-account-check",
    "Comment": "calibDB: never made",
    "Enabled": False,
    "Origins": {
        "Quantity": 1,
        "Items": [
            {
                "Id": "web",
                "DomainName": "calibdb.invalid",
                "OriginAccessControlId": "E00000000000000",
                "S3OriginConfig": {"OriginAccessIdentity": ""},
            }
        ],
    },
    "DefaultCacheBehavior": {
        "TargetOriginId": "absent",
        "ViewerProtocolPolicy": "https-only",
        "CachePolicyId": "00000000-0000-0000-0000-000000000000",
    },
}


def _certificate(acm: Any, domain: str, arn: str) -> Iterator[str]:
    if not arn:
        yield "DomainName needs CertificateArn, the ARN of a certificate for it in us-east-1."
        return
    if arn.split(":")[2:4] != ["acm", "us-east-1"]:
        yield (
            f"CertificateArn is {arn}: CloudFront takes only certificates of us-east-1, so request one for "
            f"{domain} there."
        )
        return
    try:
        certificate = acm.describe_certificate(CertificateArn=arn)["Certificate"]
    except ClientError as error:
        yield f"CertificateArn cannot be read ({code(error)}): give the ARN of a certificate of this account."
        return
    if certificate["Status"] != "ISSUED":
        yield f"The certificate is {certificate['Status']}: complete its validation first."
    names = {certificate["DomainName"], *certificate.get("SubjectAlternativeNames", ())}
    if not names & {domain, "*." + domain.partition(".")[2]}:
        yield f"The certificate is for {', '.join(sorted(names))}: request one that names {domain}."


def _zone(route53: Any, domain: str, zone: str) -> Iterator[str]:
    if not domain:
        yield "HostedZoneId needs DomainName."
        return
    try:
        name = route53.get_hosted_zone(Id=zone)["HostedZone"]["Name"].rstrip(".")
    except ClientError as error:
        yield f"HostedZoneId cannot be read ({code(error)}): give the id of a public zone of this account."
        return
    if domain != name and not domain.endswith(f".{name}"):
        yield f"The hosted zone is {name}, which does not contain {domain}: pass the zone of that domain."
