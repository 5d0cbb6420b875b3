"""Removal of what former deployments left: nothing that is in use, or may be rolled back to."""

from datetime import UTC, datetime, timedelta
from unittest.mock import call

from infra.deploy.aws import Account
from infra.deploy.prune import MAX_ARTIFACT_AGE_DAYS, MAX_VERSIONS, prune
from tests.unit.deploy.paged import paged

NOW = datetime(2026, 11, 22, tzinfo=UTC)
OLD = NOW - timedelta(days=MAX_ARTIFACT_AGE_DAYS + 1)


def test_named_and_newest_versions_and_used_artifacts_stay() -> None:
    function = {"ResourceType": "AWS::Lambda::Function", "PhysicalResourceId": "Lookup"}
    cloudformation = paged(
        {"StackResourceSummaries": [function, {"ResourceType": "AWS::SQS::Queue"}]},
        describe_stacks={
            "Stacks": [{"Outputs": [{"OutputKey": "SourceBucket", "OutputValue": "artifacts"}]}]
        },
        get_template={"TemplateBody": {"Resources": {"F": {"Code": {"S3Key": "calibdb/used"}}}}},
    )
    # A function of twelve versions, whose alias moves from the second to the twelfth
    moving = {"FunctionVersion": "2", "RoutingConfig": {"AdditionalVersionWeights": {"12": 0.1}}}
    lambda_ = paged(
        *({"Versions": [{"Version": number}]} for number in ["$LATEST", *map(str, range(1, 13))]),
        list_aliases={"Aliases": [moving]},
    )
    times = {"calibdb/used": OLD, "calibdb/old": OLD, "calibdb/young": NOW}
    s3 = paged({"Contents": [{"Key": key, "LastModified": time} for key, time in times.items()]}, {})
    clients = {"cloudformation": cloudformation, "lambda": lambda_, "s3": s3}
    done = prune(Account("calibdb", "us-east-1", clients), NOW)
    s3.get_paginator().paginate.assert_called_once_with(Bucket="artifacts", Prefix="calibdb/")
    lambda_.list_aliases.assert_called_once_with(FunctionName="Lookup")
    assert MAX_VERSIONS == 5
    # 11 to 7 stay, and those of the alias.
    assert lambda_.delete_function.mock_calls == [
        call(FunctionName="Lookup", Qualifier=number) for number in ("6", "5", "4", "3", "1")
    ]
    s3.delete_objects.assert_called_once_with(
        Bucket="artifacts", Delete={"Objects": [{"Key": "calibdb/old"}], "Quiet": True}
    )
    assert done == (5, 1)
