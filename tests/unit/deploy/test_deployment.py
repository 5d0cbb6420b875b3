"""A deployment knows what is there already, and which release each alias runs."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any, get_args
from unittest.mock import Mock, call

import boto3
import pytest
import yaml
from botocore.exceptions import ClientError
from hypothesis import example, given
from hypothesis import strategies as st

from infra.deploy import aws, deployment
from infra.deploy.prune import MAX_ARTIFACT_AGE_DAYS, MAX_VERSIONS, prune
from infra.deploy.steps import ROLLOUT, Kind, Target, parameter_file, steps


def paged(*pages: dict[str, Any], **responses: Any) -> Mock:
    """Make a client; `responses`: those of its other calls, by name."""
    client = Mock()
    client.get_paginator.return_value.paginate.return_value = pages
    for name, response in responses.items():
        getattr(client, name).return_value = response
    return client


class Cloudformation(Mock):
    """A stack, or none."""

    status: str | None = None
    outputs: Mapping[str, str] = {}
    parameters: Mapping[str, str] = {}

    def describe_stacks(self, **_: str) -> Any:
        if self.status is None:
            raise ClientError({"Error": {"Code": "ValidationError"}}, "DescribeStacks")
        parameters = [{"ParameterKey": k, "ParameterValue": v} for k, v in self.parameters.items()]
        outputs = [{"OutputKey": k, "OutputValue": v} for k, v in self.outputs.items()]
        return {"Stacks": [{"StackStatus": self.status, "Parameters": parameters, "Outputs": outputs}]}


@pytest.fixture
def cloud(monkeypatch: pytest.MonkeyPatch) -> Cloudformation:
    found = Cloudformation()
    monkeypatch.setattr(boto3, "client", lambda *_, **__: found)
    return found


@pytest.mark.parametrize("status", [None, "REVIEW_IN_PROGRESS"])
def test_first_deployment_tells_the_functions_where_the_site_is(
    cloud: Cloudformation, status: str | None
) -> None:
    cloud.status = status
    target = deployment.find_out(Target("mine", "us-east-1"))
    assert (target.exists, target.site) == (False, None)
    deploys = [s for s in steps(target) if s.command[1:2] == ("deploy",)]
    first, second = deploys
    assert second.parameters["GuidanceUrl"] == "{SiteUrl}/calibrate/"
    assert second.parameters["Rollout"] == "AllAtOnce"  # there are no calls to move yet
    # A creation that fails leaves nothing; by the second time the stack is there.
    assert first.command[first.command.index("--on-failure") + 1] == "DELETE"
    assert "--on-failure" not in second.command


def test_later_deployment_knows_the_site_and_changes_the_stack_once(cloud: Cloudformation) -> None:
    cloud.status, cloud.outputs = "UPDATE_COMPLETE", {"DistributionDomain": "d1.cloudfront.net"}
    target = deployment.find_out(Target("mine", "us-east-1", {"AlarmEmail": "a@example.org"}))
    (step,) = (s for s in steps(target) if s.command[1:2] == ("deploy",))
    assert step.parameters["GuidanceUrl"] == "https://d1.cloudfront.net/calibrate/"
    assert step.parameters["Rollout"] == ROLLOUT
    assert "--on-failure" not in step.command
    # A domain that the stack has already, and one that is given now or taken away.
    cloud.parameters = {"DomainName": "calib.example"}
    assert deployment.find_out(Target("mine", "us-east-1")).site == "https://calib.example"
    for domain, site in (("new.example", "https://new.example"), ("", "https://d1.cloudfront.net")):
        given = Target("mine", "us-east-1", {"DomainName": domain})
        assert deployment.find_out(given).site == site


def with_clients(cloudformation: Mock, lambda_: Mock | None = None) -> aws.Account:
    return aws.Account("mine", "us-east-1", {"cloudformation": cloudformation, "lambda": lambda_})


def resource(kind: str, name: str) -> dict[str, str]:
    return {"ResourceType": f"AWS::Lambda::{kind}", "PhysicalResourceId": name, "LogicalResourceId": name}


def alias(function: str) -> dict[str, str]:
    return resource("Alias", f"arn:aws:lambda:us-east-1:123456789012:function:{function}:live")


def test_release_is_read_at_the_alias_that_the_api_calls() -> None:
    """The probe belongs to no release."""
    functions = [resource("Function", name) for name in ("lookup", "refit", "Probe")]
    cloudformation = paged({"StackResourceSummaries": [*functions, alias("lookup")]})

    def configuration(FunctionName: str, Qualifier: str = "newest") -> Any:  # noqa: N803
        return {"Environment": {"Variables": {"RELEASE": f"{Qualifier} {FunctionName}"}}}

    account = with_clients(cloudformation, Mock(get_function_configuration=configuration))
    assert account.releases() == {"lookup": "live lookup", "refit": "newest refit"}


def test_step_back_points_aliases_at_the_version_before() -> None:
    cloudformation = paged({"StackResourceSummaries": [alias("lookup")]})
    versions = [{"Version": version} for version in ("$LATEST", "3", "7", "9", "10")]
    lambda_ = paged({"Versions": versions}, get_alias={"FunctionVersion": "9"})
    assert with_clients(cloudformation, lambda_).step_back() == {"lookup": ("9", "7")}
    lambda_.get_alias.assert_called_once_with(FunctionName="lookup", Name="live")
    lambda_.update_alias.assert_called_once_with(
        FunctionName="lookup",
        Name="live",
        FunctionVersion="7",
        RoutingConfig={"AdditionalVersionWeights": {}},
    )
    first = paged({"Versions": versions[:2]}, get_alias={"FunctionVersion": "3"})
    assert with_clients(cloudformation, first).step_back() == {}
    first.update_alias.assert_not_called()


def test_failed_resources_of_the_newest_stack_are_read() -> None:
    summaries = [
        {"StackName": name, "StackId": identity, "CreationTime": time}
        for time, (name, identity) in enumerate([("mine", "old"), ("mine", "new"), ("other", "other")])
    ]
    failed = {"LogicalResourceId": "B", "ResourceStatus": "CREATE_FAILED", "ResourceStatusReason": "why"}
    events = [{"LogicalResourceId": "A", "ResourceStatus": "CREATE_COMPLETE"}, failed]
    cloudformation = paged({"StackSummaries": summaries}, describe_stack_events={"StackEvents": events})
    assert with_clients(cloudformation).failures() == ["B: why"]
    cloudformation.describe_stack_events.assert_called_once_with(StackName="new")


def test_one_parameter_is_changed_and_the_others_are_kept() -> None:
    cloudformation = Cloudformation()
    cloudformation.status = "UPDATE_COMPLETE"
    cloudformation.parameters = {"AlarmEmail": "a@example.org", "EdgeSecretVersion": "1"}
    with_clients(cloudformation).set_parameter("EdgeSecretVersion", "2")
    change = cloudformation.update_stack.call_args.kwargs
    assert change["UsePreviousTemplate"] is True
    assert change["Parameters"] == [
        {"ParameterKey": "AlarmEmail", "UsePreviousValue": True},
        {"ParameterKey": "EdgeSecretVersion", "ParameterValue": "2"},
    ]


def test_stack_and_table_are_protected_once_they_are_there() -> None:
    cloudformation = Cloudformation()
    cloudformation.status, cloudformation.outputs = "CREATE_COMPLETE", {"TableName": "table"}
    account, dynamodb = with_clients(cloudformation), Mock()
    account.clients["dynamodb"] = dynamodb
    for protected in (False, True):
        dynamodb.describe_table.return_value = {"Table": {"DeletionProtectionEnabled": protected}}
        account.protect()
    cloudformation.update_termination_protection.assert_called_with(
        StackName="mine", EnableTerminationProtection=True
    )
    dynamodb.update_table.assert_called_once_with(TableName="table", DeletionProtectionEnabled=True)


NOW = datetime(2026, 11, 22, tzinfo=UTC)
OLD = NOW - timedelta(days=MAX_ARTIFACT_AGE_DAYS + 1)


def test_named_and_newest_versions_and_used_artifacts_stay() -> None:
    cloudformation = paged(
        {"StackResourceSummaries": [resource("Function", "Lookup"), alias("Lookup")]},
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
    done = prune(aws.Account("calibdb", "us-east-1", clients), NOW)
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


OTHER_STEPS = set(get_args(Kind)) - {"run"}


@pytest.fixture
def written(cloud: Cloudformation, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The parameter file of deployments of a stack; their commands do nothing."""
    cloud.status, cloud.outputs = "UPDATE_COMPLETE", {"SiteUrl": "https://d1.cloudfront.net"}
    monkeypatch.setattr(aws.Account, "edge_secret_version", lambda *_: 7)
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
