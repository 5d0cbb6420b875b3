"""The role that deploys: what a job may assume it, and what it may do."""

import fnmatch
import json
import re
from typing import Any

import pytest

from infra.local.intrinsics import parse
from tests.helpers.data import ROOT

MAX_POLICY_CHARACTERS = 6144  # IAM quotas, "managed policy size", whitespace not counted
#: actions that take no resource, by AWS's service authorization reference
UNSCOPED = {
    *("cloudformation:ValidateTemplate", "lambda:GetAccountSettings", "cloudfront:ListDistributions"),
    *("acm:DescribeCertificate", "logs:DescribeLogGroups", "logs:CreateLogDelivery"),
    *("logs:UpdateLogDelivery", "logs:DeleteLogDelivery", "logs:GetLogDelivery", "logs:ListLogDeliveries"),
    *("logs:PutResourcePolicy", "logs:DescribeResourcePolicies"),
}
#: types of resources whose service goes by another name in actions
SERVICES = {
    "ApiGatewayV2": "apigateway",
    "Budgets": "budgets",
    "Serverless": "lambda",
    "StepFunctions": "states",
    "WAFv2": "wafv2",
}


@pytest.fixture(scope="module")
def role() -> dict[str, Any]:
    return parse(ROOT / "infra/deploy/role.yaml")["Resources"]


def statements(role: dict[str, Any]) -> list[dict[str, Any]]:
    return [
        statement
        for resource in role.values()
        if resource["Type"] == "AWS::IAM::ManagedPolicy"
        for statement in resource["Properties"]["PolicyDocument"]["Statement"]
    ]


def listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def test_one_environment_of_one_repository_assumes_the_role(role: dict[str, Any]) -> None:
    (trust,) = role["DeployRole"]["Properties"]["AssumeRolePolicyDocument"]["Statement"]
    assert trust["Action"] == "sts:AssumeRoleWithWebIdentity"
    assert trust["Condition"]["StringEquals"] == {
        "token.actions.githubusercontent.com:aud": "sts.amazonaws.com",
        "token.actions.githubusercontent.com:sub": {
            "Fn::Sub": "repo:${Repository}:environment:${Environment}"
        },
    }


def test_role_names_actions_and_the_stack_s_resources(role: dict[str, Any]) -> None:
    for statement in statements(role):
        if statement["Effect"] == "Deny":
            continue
        actions = listed(statement["Action"])
        assert all(re.fullmatch(r"[a-z0-9]+:[A-Za-z0-9]+", action) for action in actions), statement["Sid"]
        if statement["Resource"] == "*":
            assert set(actions) <= UNSCOPED or "Condition" in statement, statement["Sid"]


def test_role_cannot_change_itself_nor_attach_strange_policies(role: dict[str, Any]) -> None:
    known = {statement["Sid"]: statement for statement in statements(role)}
    assert known["NotItself"]["Effect"] == "Deny"
    own = [resource["Fn::Sub"] for resource in known["NotItself"]["Resource"]]
    assert own[0].endswith(f":role/{role['DeployRole']['Properties']['RoleName']['Fn::Sub']}")
    assert all(
        resource["Properties"]["ManagedPolicyName"]["Fn::Sub"].startswith("${Stack}-deploy-")
        for resource in role.values()
        if resource["Type"] == "AWS::IAM::ManagedPolicy"
    )
    attached = known["AttachOwnPolicies"]["Condition"]["ArnLike"]["iam:PolicyARN"]
    assert not [arn for arn in attached if "Administrator" in arn["Fn::Sub"] or arn["Fn::Sub"].endswith(":*")]
    assert set(known["PassRoles"]["Condition"]["StringEquals"]["iam:PassedToService"]) == {
        f"{service}.amazonaws.com" for service in ("lambda", "states", "codedeploy", "s3")
    }


def test_policies_fit_into_iam(role: dict[str, Any]) -> None:
    for name, resource in role.items():
        if resource["Type"] == "AWS::IAM::ManagedPolicy":
            text = json.dumps(resource["Properties"]["PolicyDocument"], separators=(",", ":"))
            # The longest partition, account and region that a `!Sub` may stand for are no longer than itself.
            size = len(re.sub(r'\{"Fn::Sub":("[^"]*")\}', r"\1", text))
            assert size <= MAX_POLICY_CHARACTERS, name


def test_every_service_of_the_template_may_be_deployed(role: dict[str, Any]) -> None:
    allowed = {
        action.partition(":")[0]
        for statement in statements(role)
        if statement["Effect"] == "Allow"
        for action in listed(statement["Action"])
    }
    files = [ROOT / "template.yaml", *ROOT.glob("infra/deploy/*.yaml"), *ROOT.glob("infra/edge/*.yaml")]
    types = {
        resource["Type"]
        for file in files
        if file.name != "role.yaml"
        for resource in parse(file).get("Resources", {}).values()
    }
    needed = {SERVICES.get(kind.split("::")[1], kind.split("::")[1].lower()) for kind in types}
    assert len(needed) >= 10
    assert needed <= allowed


def test_answers_at_the_edge_may_be_removed(role: dict[str, Any]) -> None:
    """`EdgeAnswers=off` lists and deletes them."""
    bucket = "arn:aws:s3:::calibdb-webbucket-1abc2def"
    values = {"AWS::Partition": "aws", "Stack": "calibdb"}
    for action, resource in (("s3:ListBucket", bucket), ("s3:DeleteObject", f"{bucket}/known/00/1.json")):
        granted = [
            statement["Sid"]
            for statement in statements(role)
            if statement["Effect"] == "Allow" and action in listed(statement["Action"])
            for pattern in listed(statement["Resource"])
            if fnmatch.fnmatchcase(
                resource, re.sub(r"\$\{([\w:]+)\}", lambda m: values.get(m[1], m[0]), pattern["Fn::Sub"])
            )
        ]
        assert granted, action
