"""The role that deploys: what a job may assume it, and what it may do."""

import fnmatch
import json
import re
from typing import Any

import yaml

from calibdb.camera_key import camera_key
from calibdb.store.keys import calibration_object
from infra.deploy import smoke_capture
from infra.deploy.template import parse
from tests.helpers.data import ROOT
from tests.helpers.sam import created

MAX_POLICY_CHARACTERS = 6144  # IAM quotas, "managed policy size", whitespace not counted
#: actions that take no resource, by AWS's service authorization reference
UNSCOPED = {
    *("cloudformation:ValidateTemplate", "cloudformation:ListStacks", "lambda:GetAccountSettings"),
    *("cloudfront:ListDistributions", "acm:DescribeCertificate"),
    *("logs:DescribeLogGroups", "logs:CreateLogDelivery"),
    *("logs:UpdateLogDelivery", "logs:DeleteLogDelivery", "logs:GetLogDelivery", "logs:ListLogDeliveries"),
    *("logs:PutResourcePolicy", "logs:DescribeResourcePolicies"),
    "logs:DescribeDeliveries",
}


ROLE = parse(ROOT / "infra/deploy/role.yaml")["Resources"]
HANDLERS = yaml.safe_load((ROOT / "tests/unit/deploy/handler_actions.yaml").read_text())
POLICIES = {n: r["Properties"] for n, r in ROLE.items() if r["Type"] == "AWS::IAM::ManagedPolicy"}
BOUNDARY = POLICIES["Boundary"]
STATEMENTS = [s for p in POLICIES.values() if p is not BOUNDARY for s in p["PolicyDocument"]["Statement"]]
BY_SID = {statement["Sid"]: statement for statement in STATEMENTS}


def listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def test_one_environment_of_one_repository_assumes_the_role() -> None:
    (trust,) = ROLE["DeployRole"]["Properties"]["AssumeRolePolicyDocument"]["Statement"]
    assert trust["Action"] == "sts:AssumeRoleWithWebIdentity"
    assert trust["Condition"]["StringEquals"] == {
        "token.actions.githubusercontent.com:aud": "sts.amazonaws.com",
        "token.actions.githubusercontent.com:sub": {
            "Fn::Sub": "repo:${Repository}:environment:${Environment}"
        },
    }


def test_role_names_actions_and_the_stack_s_resources() -> None:
    for statement in STATEMENTS:
        if statement["Effect"] == "Deny":
            continue
        actions = listed(statement["Action"])
        assert all(re.fullmatch(r"[a-z0-9]+:[A-Za-z0-9]+", action) for action in actions), statement["Sid"]
        if statement["Resource"] == "*":
            assert set(actions) <= UNSCOPED or "Condition" in statement, statement["Sid"]


def test_role_cannot_change_itself_nor_attach_strange_policies() -> None:
    assert BY_SID["NotItself"]["Effect"] == "Deny"
    own = [resource["Fn::Sub"] for resource in BY_SID["NotItself"]["Resource"]]
    assert own[0].endswith(f":role/{ROLE['DeployRole']['Properties']['RoleName']['Fn::Sub']}")
    names = [policy["ManagedPolicyName"]["Fn::Sub"] for policy in POLICIES.values() if policy is not BOUNDARY]
    assert all(name.startswith("${Stack}-deploy-") for name in names)
    attached = BY_SID["AttachOwnPolicies"]["Condition"]["ArnLike"]["iam:PolicyARN"]
    assert not [arn for arn in attached if "Administrator" in arn["Fn::Sub"] or arn["Fn::Sub"].endswith(":*")]
    assert set(BY_SID["PassRoles"]["Condition"]["StringEquals"]["iam:PassedToService"]) == {
        f"{service}.amazonaws.com" for service in ("lambda", "states", "codedeploy", "s3")
    }


def test_every_managed_policy_of_the_stack_may_be_attached() -> None:
    """SAM's transform attaches policies that no file of the project names."""
    allowed = BY_SID["AttachOwnPolicies"]["Condition"]["ArnLike"]["iam:PolicyARN"]
    patterns = [pattern["Fn::Sub"].replace("${AWS::Partition}", "aws") for pattern in allowed]
    attached = {
        arn.replace("${AWS::Partition}", "aws")
        for resource in created().values()
        if resource["Type"] == "AWS::IAM::Role"
        for arn in strings(resource["Properties"].get("ManagedPolicyArns", []))
        if arn.startswith("arn:")
    }
    assert len(attached) >= 4
    assert [a for a in attached if not any(fnmatch.fnmatchcase(a, pattern) for pattern in patterns)] == []


def strings(value: Any) -> list[str]:
    """Collect the texts in nested lists and intrinsic functions."""
    if isinstance(value, str):
        return [value]
    items = value.values() if isinstance(value, dict) else value
    return [text for item in items for text in strings(item)]


def test_every_handler_of_the_stack_s_resources_is_allowed() -> None:
    allowed = {a for s in STATEMENTS if s["Effect"] == "Allow" for a in listed(s["Action"])}
    types = {resource["Type"] for resource in created().values()}
    assert types == HANDLERS.keys(), "types whose actions are not listed, or that the stack lacks"
    required = {
        f"{service}:{name}"
        for kind in types
        for service, names in HANDLERS[kind].items()
        for name in names.split()
    }
    assert len(required) > 100
    assert sorted(required - allowed) == []


def test_no_version_of_an_object_can_be_removed() -> None:
    actions = [a for s in STATEMENTS if s["Effect"] == "Allow" for a in listed(s["Action"])]
    assert not [a for a in actions if fnmatch.fnmatchcase("s3:DeleteObjectVersion", a)]
    removing = [s for s in STATEMENTS if "s3:DeleteObject" in listed(s["Action"])]
    places = [r["Fn::Sub"].rpartition(":::")[2] for s in removing for r in listed(s["Resource"])]
    key = camera_key(smoke_capture.CAMERA, "X11; Linux x86_64")
    data = [place for place in places if "keypointbucket" in place or "replica" in place]
    assert len(data) == 2
    for place in data:
        pattern = place.partition("/")[2]
        assert fnmatch.fnmatchcase(calibration_object(f"{key}-{'0' * 20}"), pattern)
        assert not fnmatch.fnmatchcase("calibrations/c4-another-63e5891877a7/x.json", pattern)


def test_every_role_of_the_stack_has_the_boundary() -> None:
    roles = {name: r["Properties"] for name, r in created().items() if r["Type"] == "AWS::IAM::Role"}
    assert len(roles) >= 20
    boundary = {"Fn::If": ["Bounded", {"Ref": "PermissionsBoundary"}, {"Ref": "AWS::NoValue"}]}
    assert [name for name, role in roles.items() if role.get("PermissionsBoundary") != boundary] == []


def test_boundary_allows_what_the_roles_are_given() -> None:
    """Without the wildcards of AWS's own policies: they stand for these actions."""
    allowed = {a for s in BOUNDARY["PolicyDocument"]["Statement"] for a in listed(s["Action"])}
    granted = [s for resource in created().values() for d in documents(resource) for s in d["Statement"]]
    given = {action for statement in granted for action in listed(statement["Action"])}
    of_aws = {
        *("logs:CreateLogStream", "logs:PutLogEvents", "xray:PutTraceSegments", "xray:PutTelemetryRecords"),
        *("sqs:ReceiveMessage", "sqs:DeleteMessage", "sqs:GetQueueAttributes"),
        *("lambda:UpdateAlias", "lambda:GetAlias", "lambda:GetProvisionedConcurrencyConfig"),
        "cloudwatch:DescribeAlarms",
    }
    assert len(given) >= 15
    assert sorted((given | of_aws) - allowed) == []


def documents(resource: dict[str, Any]) -> list[dict[str, Any]]:
    """Policies that a role has, or that can be attached to it."""
    properties = resource["Properties"]
    if resource["Type"] in ("AWS::IAM::ManagedPolicy", "AWS::IAM::RolePolicy"):
        return [properties["PolicyDocument"]]
    if resource["Type"] == "AWS::IAM::Role":
        return [policy["PolicyDocument"] for policy in properties.get("Policies", [])]
    return []


def test_roles_are_made_and_changed_with_the_boundary_only() -> None:
    granting = {
        "iam:CreateRole",
        "iam:PutRolePermissionsBoundary",
        "iam:PutRolePolicy",
        "iam:AttachRolePolicy",
    }
    boundary = BOUNDARY["ManagedPolicyName"]["Fn::Sub"]
    found = set()
    for statement in STATEMENTS:
        if statement["Effect"] == "Allow" and (actions := granting & set(listed(statement["Action"]))):
            required = statement["Condition"]["StringEquals"]["iam:PermissionsBoundary"]["Fn::Sub"]
            assert required.endswith(f":policy/{boundary}"), statement["Sid"]
            found |= actions
    assert found == granting
    denied = BY_SID["NotItself"]["Resource"]
    assert any(resource["Fn::Sub"].endswith(f":policy/{boundary}") for resource in denied)
    actions = [a for s in STATEMENTS for a in listed(s["Action"])]
    assert "iam:DeleteRolePermissionsBoundary" not in actions


def test_policies_fit_into_iam() -> None:
    for name, policy in POLICIES.items():
        text = json.dumps(policy["PolicyDocument"], separators=(",", ":"))
        # The longest partition, account and region that a `!Sub` may stand for are no longer than itself.
        size = len(re.sub(r'\{"Fn::Sub":("[^"]*")\}', r"\1", text))
        assert size <= MAX_POLICY_CHARACTERS, name
