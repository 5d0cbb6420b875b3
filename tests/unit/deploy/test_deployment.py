"""A deployment knows what is there already, and which release each alias runs."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import boto3
import pytest
import yaml
from botocore.exceptions import ClientError
from hypothesis import example, given
from hypothesis import strategies as st

from infra.deploy import aws, deployment
from infra.deploy.steps import ROLLOUT, Target, parameter_file, steps


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
    deploys = [s for s in steps(target) if s.command[1:2] == ("deploy",)]
    assert len(deploys) == 2
    assert deploys[1].parameters["GuidanceUrl"] == "{SiteUrl}/calibrate/"
    assert deploys[1].parameters["Rollout"] == "AllAtOnce"  # there are no calls to move yet
    assert cloud.changes == []


def test_later_deployment_knows_the_site_and_changes_the_stack_once(cloud: Cloudformation) -> None:
    cloud.status, cloud.outputs = "UPDATE_COMPLETE", {"DistributionDomain": "d1.cloudfront.net"}
    target = deployment.find_out(Target("mine", "us-east-1", {"AlarmEmail": "a@example.org"}))
    (step,) = (s for s in steps(target) if s.command[1:2] == ("deploy",))
    assert step.parameters["GuidanceUrl"] == "https://d1.cloudfront.net/calibrate/"
    assert step.parameters["Rollout"] == ROLLOUT
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
    """The probe belongs to no release."""
    cloudformation = Cloudformation()
    cloudformation.functions = ("lookup", "refit", "Probe")

    class Lambda:
        def get_function_configuration(self, **asked: str) -> Any:
            release = {"lookup": "old", "refit": "new"}.get(asked["FunctionName"])
            assert asked.get("Qualifier") == ("live" if asked["FunctionName"] == "lookup" else None)
            return {"Environment": {"Variables": {"RELEASE": release} if release else {}}}

    assert aws.releases(cloudformation, Lambda(), "mine") == {"lookup": "old", "refit": "new"}


def test_step_back_points_aliases_at_the_version_before() -> None:
    versions = {"lookup": (["$LATEST", "3", "7", "9", "10"], "9"), "refit": (["$LATEST", "4"], "4")}
    changes: list[dict[str, Any]] = []

    class Lambda:
        def get_alias(self, **asked: str) -> Any:
            return {"FunctionVersion": versions[asked["FunctionName"]][1]}

        def get_paginator(self, name: str) -> Any:
            assert name == "list_versions_by_function"
            return self

        def paginate(self, **asked: str) -> Any:
            return [{"Versions": [{"Version": v} for v in versions[asked["FunctionName"]][0]]}]

        def update_alias(self, **change: Any) -> None:
            changes.append(change)

    class Resources:
        def get_paginator(self, _: str) -> Any:
            return self

        def paginate(self, **_: str) -> Any:
            names = [f"arn:aws:lambda:us-east-1:123456789012:function:{name}:live" for name in versions]
            rows = [{"ResourceType": "AWS::Lambda::Alias", "PhysicalResourceId": name} for name in names]
            return [{"StackResourceSummaries": rows}]

    assert aws.step_back(Resources(), Lambda(), "mine") == {"lookup": ("9", "7")}
    (change,) = changes
    assert (change["FunctionName"], change["Name"], change["FunctionVersion"]) == ("lookup", "live", "7")
    assert change["RoutingConfig"] == {"AdditionalVersionWeights": {}}


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


OTHER_STEPS = ("account", "build", "package", "secrets", "upload", "invalidate", "protect", "prune", "smoke")


@pytest.fixture
def written(cloud: Cloudformation, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The parameter file of deployments of a stack; their commands do nothing."""
    cloud.status, cloud.outputs = "UPDATE_COMPLETE", {"SiteUrl": "https://d1.cloudfront.net"}
    monkeypatch.setattr(aws, "edge_secret_version", lambda *_: 7)
    monkeypatch.setattr(deployment, "PARAMETERS", tmp_path / "parameters.yaml")
    monkeypatch.setattr(deployment, "_run", lambda *_: None)
    monkeypatch.setattr(deployment, "find_out", lambda target: target)
    return tmp_path / "parameters.yaml"


def test_parameters_are_filled_in_from_the_account(
    cloud: Cloudformation, monkeypatch: pytest.MonkeyPatch, written: Path
) -> None:
    read: list[dict[str, str]] = []

    def run(command: Sequence[str], _: Target) -> None:
        if command[1] == "deploy":
            read.append(as_sam_reads(written.read_text()))
            cloud.parameters = read[-1]

    monkeypatch.setattr(deployment, "_run", run)
    target = Target("mine", "us-east-1", {"OperatorName": "Jane Doe", "AlarmEmail": ""})
    deployment.deploy(target, {"unused": True}, OTHER_STEPS)
    first, again = read
    assert first["EdgeSecretVersion"] == "7"
    assert again["GuidanceUrl"] == "https://d1.cloudfront.net/calibrate/"
    assert (again["OperatorName"], again["AlarmEmail"]) == ("Jane Doe", "")
    assert not any("{" in value for value in (*first.values(), *again.values()))


@pytest.mark.usefixtures("written")
def test_deployment_fails_if_the_stack_has_other_parameters(cloud: Cloudformation) -> None:
    cloud.parameters = {"OperatorName": "Jane", "EdgeSecretVersion": "7", "Rollout": ROLLOUT}
    target = Target("mine", "us-east-1", {"OperatorName": "Jane Doe"})
    with pytest.raises(aws.DeployError, match=r"other values than asked for: OperatorName$"):
        deployment.deploy(target, {"unused": True}, OTHER_STEPS)


@example("Foo Ltd|12 High Street|\"Room\" 'B'")
@example('C:\\ \\" \\')
@example("")
@given(st.text(st.characters(codec="utf-8", exclude_categories=["C"])))
def test_values_survive_the_parameter_file(value: str) -> None:
    assert as_sam_reads(parameter_file({"Imprint": value, "Other": "x"})) == {"Imprint": value, "Other": "x"}


def as_sam_reads(text: str) -> dict[str, str]:
    """Parameters as SAM CLI 1.170 reads a file of them: it takes the outer quotes off twice.

    `make verify ONLY=rehearsal` asks the SAM CLI itself.
    """
    values: dict[str, str] = yaml.safe_load(text)
    for _ in range(2):
        values = {name: unquoted(value) for name, value in values.items()}
    return values


def unquoted(value: str) -> str:
    if value and value[0] == value[-1] and value[0] in "\"'":
        value = value[1:-1]
    for character in " \"'":
        value = value.replace("\\" + character, character)
    return value
