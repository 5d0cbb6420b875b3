"""Rehearsal of the deployment against ministack: `python -m infra.deploy.rehearsal`.

Everything is done by what does it on AWS: SAM's command line packs and uploads functions and layers, a stack
is made of the template and changed, the site is uploaded, the pages get their token, the keys are rotated.
What ministack does not know, or what only AWS can answer, is left out and said.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator

import boto3

from infra.ci import ministack
from infra.deploy import aws
from infra.deploy.__main__ import DeployError, deploy
from infra.deploy.steps import ROOT, Target

REHEARSAL = Target("rehearsal", "us-east-1", {"AlarmEmail": "operator@example.org"})
# Of the template, what ministack cannot make: budgets, and alarms on a sum.
_UNSUPPORTED = ("Budget", "ThrottleAlarm")
# Nobody delivers the site there, and its functions run on AWS's processors.
_ONLY_ON_AWS = ("smoke",)


def main() -> int:
    """Deploy twice and rotate; return 1 where what is there then is not what must be."""
    with ministack.serving() as url:
        os.environ |= {
            "AWS_ENDPOINT_URL": url,
            "AWS_ACCESS_KEY_ID": "rehearsal",
            "AWS_SECRET_ACCESS_KEY": "rehearsal",
            "AWS_REGION": REHEARSAL.region,
            "AWS_DEFAULT_REGION": REHEARSAL.region,
        }
        os.environ.pop("AWS_PROFILE", None)
        template = remove_unsupported((ROOT / "template.yaml").read_text(encoding="utf-8"))
        try:
            deploy(REHEARSAL, template, _ONLY_ON_AWS)
            settings = _settings()
            deploy(REHEARSAL, template, _ONLY_ON_AWS)
            aws.rotate(boto3.client("ssm"), REHEARSAL.stack)
        except DeployError as error:
            print(f"calibDB: {error}", file=sys.stderr)
            return 1
        found = list(problems())
        if _settings() != settings:
            found.append("the second deployment gave the pages another token")
    print(f"left out: {', '.join((*_UNSUPPORTED, *_ONLY_ON_AWS))}")
    for problem in found:
        print(f"calibDB: {problem}", file=sys.stderr)
    return 1 if found else 0


def remove_unsupported(template: str) -> str:
    """Remove the resources that ministack does not support."""
    for name in _UNSUPPORTED:
        template = re.sub(rf"(?m)^  {name}:\n(?:    .*\n|\n)+", "", template)
    return template


def problems() -> Iterator[str]:
    """Find the differences between the template and the deployed resources."""
    cloudformation = boto3.client("cloudformation")
    (stack,) = cloudformation.describe_stacks(StackName=REHEARSAL.stack)["Stacks"]
    if stack["StackStatus"] != "UPDATE_COMPLETE":
        yield f"the stack is {stack['StackStatus']}"
    made = aws.outputs(cloudformation, REHEARSAL.stack)
    parameters = {p["ParameterKey"]: p["ParameterValue"] for p in stack["Parameters"]}
    if parameters["GuidanceUrl"] != f"{made['SiteUrl']}/calibrate/":
        yield f"lookups are sent to {parameters['GuidanceUrl']}"
    s3 = boto3.client("s3")
    for bucket in (made["KeypointBucketName"], made["WebBucketName"]):
        if s3.get_bucket_versioning(Bucket=bucket).get("Status") != "Enabled":
            yield f"{bucket} keeps no versions"
        closed = s3.get_public_access_block(Bucket=bucket)["PublicAccessBlockConfiguration"]
        if not all(closed.values()):
            yield f"{bucket} can be made public"
        if "aws:SecureTransport" not in s3.get_bucket_policy(Bucket=bucket)["Policy"]:
            yield f"{bucket} is open without TLS"
    secrets = boto3.client("ssm").get_parameters_by_path(
        Path=f"/calibdb/{REHEARSAL.stack}", WithDecryption=True
    )
    keys = {p["Name"].rpartition("/")[2]: p["Value"].count(",") + 1 for p in secrets["Parameters"]}
    if keys != {"SESSION_SECRETS": 3, "CONTRIBUTOR_SECRET": 1, "EDGE_SECRET": 1}:
        yield f"the secrets hold so many keys: {keys}"
    page = s3.head_object(Bucket=made["WebBucketName"], Key="calibrate/index.html")
    if page["ContentType"] != "text/html; charset=utf-8":
        yield f"a page is {page['ContentType']}"
    print(f"{len(_resources())} resources, {len(made)} outputs")


def _resources() -> list[object]:
    pages = boto3.client("cloudformation").get_paginator("list_stack_resources")
    return [r for page in pages.paginate(StackName=REHEARSAL.stack) for r in page["StackResourceSummaries"]]


def _settings() -> dict[str, str]:
    made = aws.outputs(boto3.client("cloudformation"), REHEARSAL.stack)
    return dict(aws.settings(boto3.client("s3"), made["WebBucketName"]) or {})


if __name__ == "__main__":
    sys.exit(main())
