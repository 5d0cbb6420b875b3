"""Removal of old versions of functions, and of artifacts that no template names."""

import json
from datetime import datetime, timedelta

from calibdb.store.aws import S3Objects
from infra.deploy.aws import FUNCTION, Account

MAX_VERSIONS = 5  # of a function, besides those that an alias names: to roll back to
MAX_ARTIFACT_AGE_DAYS = 90  # of what the deployed template does not name
_MANAGED = "aws-sam-cli-managed-default"  # stack in which the SAM CLI keeps its bucket


def prune(account: Account, now: datetime) -> tuple[int, int]:
    """Remove old versions and artifacts; return the numbers of both."""
    functions = account.resources(FUNCTION)
    versions = sum(_prune_versions(account, each["PhysicalResourceId"]) for each in functions)
    outputs = account.client("cloudformation").describe_stacks(StackName=_MANAGED)["Stacks"][0]["Outputs"]
    bucket = next(output["OutputValue"] for output in outputs if output["OutputKey"] == "SourceBucket")
    return versions, _prune_artifacts(account, bucket, now)


def _prune_versions(account: Account, function: str) -> int:
    """Delete all but the newest versions and those that an alias names, also for a part of the calls."""
    lambda_ = account.client("lambda")
    aliases = lambda_.list_aliases(FunctionName=function)["Aliases"]
    named = {alias["FunctionVersion"] for alias in aliases}
    for alias in aliases:
        named |= set((alias.get("RoutingConfig") or {}).get("AdditionalVersionWeights") or {})
    published = sorted(account.versions(function), reverse=True)
    unused = [number for number in published if str(number) not in named]
    for number in unused[MAX_VERSIONS:]:
        lambda_.delete_function(FunctionName=function, Qualifier=str(number))
    return len(unused[MAX_VERSIONS:])


def _prune_artifacts(account: Account, bucket: str, now: datetime) -> int:
    """Delete old artifacts of this stack that its template does not name.

    A change that fails is rolled back to the template before it, whose artifacts are younger, or named still.
    """
    s3 = account.client("s3")
    deployed = account.client("cloudformation").get_template(StackName=account.stack)
    template = json.dumps(deployed["TemplateBody"], default=str)
    oldest = now - timedelta(days=MAX_ARTIFACT_AGE_DAYS)
    names = [
        item["Key"]
        for page in s3.get_paginator("list_objects_v2").paginate(Bucket=bucket, Prefix=f"{account.stack}/")
        for item in page.get("Contents", ())
        if item["LastModified"] < oldest and item["Key"] not in template
    ]
    S3Objects(lambda: s3, bucket).delete(names)
    return len(names)
