"""A deployment knows what is there already, and which release each alias runs."""

import os
from typing import Any

import boto3
import pytest
from botocore.exceptions import ClientError

from infra.deploy import aws, deployment
from infra.deploy.steps import ROLLOUT, Target, steps


class Cloudformation:
    """A stack, or none, and its resources."""

    def __init__(self, status: str | None = None, **outputs: str) -> None:
        self.status = status
        self.outputs = outputs
        self.parameters: dict[str, str] = {}
        self.changes: list[dict[str, Any]] = []
        self.functions: tuple[str, ...] = ()

    def describe_stacks(self, **_: str) -> Any:
        if self.status is None:
            raise ClientError({"Error": {"Code": "ValidationError"}}, "DescribeStacks")
        parameters = [{"ParameterKey": k, "ParameterValue": v} for k, v in self.parameters.items()]
        outputs = [{"OutputKey": k, "OutputValue": v} for k, v in self.outputs.items()]
        return {"Stacks": [{"StackStatus": self.status, "Parameters": parameters, "Outputs": outputs}]}

    def update_stack(self, **change: Any) -> None:
        self.changes.append(change)

    def update_termination_protection(self, **change: Any) -> None:
        self.changes.append(change)

    def get_waiter(self, _: str) -> Any:
        return type("Waiter", (), {"wait": lambda *_, **__: None})()

    def get_paginator(self, name: str) -> Any:
        pages = {
            "list_stack_resources": {
                "StackResourceSummaries": [
                    *(
                        {
                            "LogicalResourceId": f,
                            "PhysicalResourceId": f,
                            "ResourceType": "AWS::Lambda::Function",
                        }
                        for f in self.functions
                    ),
                    {
                        "PhysicalResourceId": "arn:aws:lambda:us-east-1:123456789012:function:lookup:live",
                        "ResourceType": "AWS::Lambda::Alias",
                    },
                ]
            },
            "list_stacks": {
                "StackSummaries": [
                    {"StackName": "mine", "StackId": "old", "CreationTime": 1},
                    {"StackName": "mine", "StackId": "new", "CreationTime": 2},
                    {"StackName": "other", "StackId": "other", "CreationTime": 3},
                ]
            },
        }
        return type("Pages", (), {"paginate": lambda *_, **__: [pages[name]]})()

    def describe_stack_events(self, **asked: str) -> Any:
        assert asked["StackName"] == "new"
        return {
            "StackEvents": [
                {"LogicalResourceId": "A", "ResourceStatus": "CREATE_COMPLETE"},
                {"LogicalResourceId": "B", "ResourceStatus": "CREATE_FAILED", "ResourceStatusReason": "why"},
            ]
        }


@pytest.fixture
def cloud(monkeypatch: pytest.MonkeyPatch) -> Cloudformation:
    found = Cloudformation()
    monkeypatch.setattr(boto3, "client", lambda *_, **__: found)
    return found


def test_first_deployment_tells_the_functions_where_the_site_is(cloud: Cloudformation) -> None:
    target = deployment.find_out(Target("mine", "us-east-1"))
    assert (target.exists, target.site) == (False, None)
    deploys = [s.command for s in steps(target) if s.command[1:2] == ("deploy",)]
    assert len(deploys) == 2
    assert "GuidanceUrl={SiteUrl}/calibrate/" in deploys[1]
    assert "Rollout=AllAtOnce" in deploys[1]  # there are no calls to move yet
    assert cloud.changes == []


def test_later_deployment_knows_the_site_and_changes_the_stack_once(cloud: Cloudformation) -> None:
    cloud.status, cloud.outputs = "UPDATE_COMPLETE", {"DistributionDomain": "d1.cloudfront.net"}
    target = deployment.find_out(Target("mine", "us-east-1", {"AlarmEmail": "a@example.org"}))
    (command,) = (s.command for s in steps(target) if s.command[1:2] == ("deploy",))
    assert "GuidanceUrl=https://d1.cloudfront.net/calibrate/" in command
    assert f"Rollout={ROLLOUT}" in command
    # A domain that the stack has already, and one that is given now or taken away.
    cloud.parameters = {"DomainName": "calib.example"}
    assert deployment.find_out(Target("mine", "us-east-1")).site == "https://calib.example"
    for domain, site in (("new.example", "https://new.example"), ("", "https://d1.cloudfront.net")):
        given = Target("mine", "us-east-1", {"DomainName": domain})
        assert deployment.find_out(given).site == site


def test_stack_without_resources_is_not_there(cloud: Cloudformation) -> None:
    cloud.status = "REVIEW_IN_PROGRESS"
    assert not deployment.find_out(Target("mine", "us-east-1")).exists


def test_release_is_read_at_the_alias_that_the_api_calls() -> None:
    cloudformation = Cloudformation()
    cloudformation.functions = ("lookup", "refit")

    class Lambda:
        def get_function_configuration(self, **asked: str) -> Any:
            release = {"lookup": "old", "refit": "new"}[asked["FunctionName"]]
            assert asked.get("Qualifier") == ("live" if asked["FunctionName"] == "lookup" else None)
            return {"Environment": {"Variables": {"RELEASE": release}}}

    assert aws.releases(cloudformation, Lambda(), "mine") == {"lookup": "old", "refit": "new"}


def test_failed_resources_of_the_newest_stack_are_read() -> None:
    assert aws.failures(Cloudformation(), "mine") == ["B: why"]


def test_one_parameter_is_changed_and_the_others_are_kept() -> None:
    cloudformation = Cloudformation("UPDATE_COMPLETE")
    cloudformation.parameters = {"AlarmEmail": "a@example.org", "EdgeSecretVersion": "1"}
    aws.set_parameter(cloudformation, "mine", "EdgeSecretVersion", "2")
    (change,) = cloudformation.changes
    assert change["UsePreviousTemplate"] is True
    assert change["Parameters"] == [
        {"ParameterKey": "AlarmEmail", "UsePreviousValue": True},
        {"ParameterKey": "EdgeSecretVersion", "ParameterValue": "2"},
    ]


def test_stack_and_table_are_protected_once_they_are_there() -> None:
    cloudformation = Cloudformation("CREATE_COMPLETE", TableName="table")
    changes: list[dict[str, Any]] = []

    class Dynamodb:
        protected = False

        def describe_table(self, **_: str) -> Any:
            return {"Table": {"DeletionProtectionEnabled": self.protected}}

        def update_table(self, **change: Any) -> None:
            self.protected = True
            changes.append(change)

    dynamodb = Dynamodb()
    for _ in range(2):
        aws.protect(cloudformation, dynamodb, "mine")
    assert cloudformation.changes[0] == {"StackName": "mine", "EnableTerminationProtection": True}
    assert changes == [{"TableName": "table", "DeletionProtectionEnabled": True}]


def test_commands_are_filled_in_from_the_account(
    cloud: Cloudformation, monkeypatch: pytest.MonkeyPatch
) -> None:
    cloud.status, cloud.outputs = "UPDATE_COMPLETE", {"SiteUrl": "https://d1.cloudfront.net"}
    monkeypatch.setattr(aws, "edge_secret_version", lambda *_: 7)
    run: list[list[str]] = []
    monkeypatch.setattr(deployment, "_run", lambda command, _: run.append(command))
    monkeypatch.setattr(deployment, "find_out", lambda target: target)
    every = ("account", "build", "package", "secrets", "upload", "invalidate", "protect", "prune", "smoke")
    deployment.deploy(Target("mine", "us-east-1"), "unused", every)
    _validated, first, again = run
    assert "EdgeSecretVersion=7" in first
    assert "GuidanceUrl=https://d1.cloudfront.net/calibrate/" in again
    assert not any("{" in word for command in run for word in command)
    assert os.sep not in first[-1]


@pytest.mark.parametrize("denied", [False, True])
def test_answers_are_removed_or_the_deployment_fails(denied: bool) -> None:
    names = [f"known/{n:02x}/a.json" for n in range(3)]
    removed: list[str] = []

    class S3:
        def get_paginator(self, operation: str) -> "S3":
            assert operation == "list_objects_v2"
            return self

        def paginate(self, **asked: str) -> Any:
            assert asked == {"Bucket": "web", "Prefix": "known/"}
            return iter([{"Contents": [{"Key": name} for name in names]}, {}])

        def delete_objects(self, **asked: Any) -> Any:
            if denied:
                return {"Errors": [{"Key": names[0], "Code": "AccessDenied"}]}
            removed.extend(entry["Key"] for entry in asked["Delete"]["Objects"])
            return {}

    if denied:
        with pytest.raises(
            aws.DeployError, match=r"1 answers at the edge remain: AccessDenied known/00/a\.json"
        ):
            aws.remove_answers(S3(), "web")
    else:
        assert aws.remove_answers(S3(), "web") == 3
        assert removed == names
