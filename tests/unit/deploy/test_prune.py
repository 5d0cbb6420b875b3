"""Removal of what former deployments left: nothing that is in use, or may be rolled back to."""

from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from typing import Any

from infra.deploy.prune import MAX_ARTIFACT_AGE_DAYS, MAX_VERSIONS, prune

NOW = datetime(2026, 11, 22, tzinfo=UTC)
OLD = NOW - timedelta(days=MAX_ARTIFACT_AGE_DAYS + 1)


class Pages:
    def __init__(self, *pages: dict[str, Any]) -> None:
        self._pages = pages

    def paginate(self, **_: str) -> Iterator[dict[str, Any]]:
        return iter(self._pages)


class CloudFormation:
    """A stack with one function, whose template names one artifact."""

    def get_paginator(self, _: str) -> Pages:
        function = {"ResourceType": "AWS::Lambda::Function", "PhysicalResourceId": "calibdb-Lookup-1"}
        return Pages({"StackResourceSummaries": [function, {"ResourceType": "AWS::SQS::Queue"}]})

    def describe_stacks(self, **_: str) -> dict[str, Any]:
        outputs = [{"OutputKey": "SourceBucket", "OutputValue": "artifacts"}]
        return {"Stacks": [{"Outputs": outputs}]}

    def get_template(self, **_: str) -> dict[str, Any]:
        return {"TemplateBody": {"Resources": {"F": {"Code": {"S3Key": "calibdb/used"}}}}}


class Lambda:
    """A function of twelve versions; its alias moves from the second to the twelfth."""

    def __init__(self) -> None:
        self.deleted: list[str] = []

    def list_aliases(self, **_: str) -> dict[str, Any]:
        moving = {"AdditionalVersionWeights": {"12": 0.1}}
        return {"Aliases": [{"FunctionVersion": "2", "RoutingConfig": moving}]}

    def get_paginator(self, _: str) -> Pages:
        numbers = ["$LATEST", *map(str, range(1, 13))]
        return Pages(*({"Versions": [{"Version": number}]} for number in numbers))

    def delete_function(self, FunctionName: str, Qualifier: str) -> None:  # noqa: N803
        assert FunctionName == "calibdb-Lookup-1"
        self.deleted.append(Qualifier)


class S3:
    def __init__(self) -> None:
        self.deleted: list[str] = []

    def get_paginator(self, _: str) -> Pages:
        known = (("calibdb/used", OLD), ("calibdb/old", OLD), ("calibdb/young", NOW))
        return Pages({"Contents": [{"Key": key, "LastModified": time} for key, time in known]}, {})

    def delete_objects(self, Bucket: str, Delete: dict[str, Any]) -> None:  # noqa: N803
        assert Bucket == "artifacts"
        self.deleted += [found["Key"] for found in Delete["Objects"]]


def test_named_and_newest_versions_and_used_artifacts_stay() -> None:
    lambda_, s3 = Lambda(), S3()
    done = prune({"cloudformation": CloudFormation(), "lambda": lambda_, "s3": s3}, "calibdb", NOW)
    assert MAX_VERSIONS == 5
    assert lambda_.deleted == ["6", "5", "4", "3", "1"]  # 11 to 7 stay, and those of the alias
    assert s3.deleted == ["calibdb/old"]
    assert done == (5, 1)
