"""The role that deploys: what a job may assume it, and what it may do."""

import fnmatch
import importlib.util
import json
import re
from pathlib import Path
from typing import Any

from calibdb.camera_key import camera_key
from calibdb.store.keys import calibration_object
from infra.deploy import smoke_capture
from infra.deploy.template import parse
from tests.helpers.data import ROOT
from tests.helpers.sam import created

#: actions that take no resource, by AWS's service authorization reference
UNSCOPED = {
    *("cloudformation:ValidateTemplate", "cloudformation:ListStacks", "lambda:GetAccountSettings"),
    *("cloudfront:ListDistributions", "acm:DescribeCertificate"),
    *("logs:DescribeLogGroups", "logs:CreateLogDelivery"),
    *("logs:UpdateLogDelivery", "logs:DeleteLogDelivery", "logs:GetLogDelivery", "logs:ListLogDeliveries"),
    *("logs:PutResourcePolicy", "logs:DescribeResourcePolicies"),
    "logs:DescribeDeliveries",
}

#: Words of writing actions of CloudFormation's handlers, of properties that the stack does not set
UNSET = {
    **dict.fromkeys(("apigateway", "budgets", "cloudwatch", "events", "wafv2"), "TagResource UntagResource"),
    "cloudfront": "ConnectionGroup WithTags StagingConfig",
    "codedeploy": "OnPremises UntagResource",
    "dynamodb": """
        Replica Kinesis Import ResourcePolicy ContributorInsights BatchWrite UpdateItem UntagResource
    """,
    "iam": "GroupPolicy UserPolicy ServiceLinked DeleteRolePermissionsBoundary",
    "lambda": "CodeSigning Provisioned RuntimeAlias RuntimeManagement Scaling Capacity Recursion",
    "logs": """
        Vended Kms LogStream LogEvents DataProtection DestinationPolicy IndexPolicy DeleteResourcePolicy
        DeleteRetentionPolicy BearerToken DeletionProtection DeliveryConfiguration
    """,
    "s3": """
        Metadata Analytics Cors CORS DeleteBucketEncryption DeleteBucketLifecycle DeleteBucketReplication
        PutBucketReplication Metrics Website Accelerate Abac Acl Logging Notification ObjectLock Ownership
        Intelligent Inventory REST TagResource UntagResource
    """,
    "sns": "DataProtection SetSubscription",
}
#: reading ones
UNREAD = {
    *("cloudfront:GetConnectionGroup", "cloudfront:GetVpcOrigin", "codedeploy:ListDeployments"),
    *("codedeploy:ListTagsForResource", "dynamodb:DescribeImport", "dynamodb:Scan"),
    *("lambda:GetCodeSigningConfig", "lambda:GetFunctionScalingConfig", "logs:DescribeIndexPolicies"),
    *("logs:DescribeLogStreams", "s3:GetBucketAbac", "s3:GetObjectMetadata", "s3:GetObjectVersion"),
    *("s3:ListTagsForResource", "s3:getObject"),
}
#: services that the stack does not use
UNUSED = {
    *("autoloop", "billing", "codewhisperer", "ec2", "elasticfilesystem", "firehose", "kinesis", "kms"),
    *("payments", "s3files", "s3tables", "workmail"),
}

ROLE = parse(ROOT / "infra/deploy/role.yaml")["Resources"]
POLICIES = {n: r["Properties"] for n, r in ROLE.items() if r["Type"] == "AWS::IAM::ManagedPolicy"}
BOUNDARY = POLICIES["Boundary"]
STATEMENTS = [s for p in POLICIES.values() if p is not BOUNDARY for s in p["PolicyDocument"]["Statement"]]
ALLOWED = {a for s in STATEMENTS if s["Effect"] == "Allow" for a in s["Action"]}
BY_SID = {statement["Sid"]: statement for statement in STATEMENTS}


def listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def test_one_environment_of_one_repository_assumes_the_role() -> None:
    (trust,) = ROLE["DeployRole"]["Properties"]["AssumeRolePolicyDocument"]["Statement"]
    assert trust["Action"] == ["sts:AssumeRoleWithWebIdentity"]
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
        actions = statement["Action"]
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
        for arn in re.findall(r'"(arn:[^"]+)"', json.dumps(resource["Properties"].get("ManagedPolicyArns")))
    }
    assert len(attached) >= 4
    assert [a for a in attached if not any(fnmatch.fnmatchcase(a, pattern) for pattern in patterns)] == []


def test_every_handler_of_the_stack_s_resources_is_allowed() -> None:
    required = {
        *("route53:ChangeResourceRecordSets", "route53:ListResourceRecordSets", "route53:GetHostedZone"),
        *("route53:GetChange", "cloudfront:AllowVendedLogDeliveryForResource"),
    }
    for kind in {resource["Type"] for resource in created().values()}:
        required |= handler_actions(kind)
    assert len(required) > 300
    assert sorted(action for action in required - ALLOWED - UNREAD if is_of_the_stack(action)) == []


def is_of_the_stack(action: str) -> bool:
    service, _, name = action.partition(":")
    is_read = name.startswith(("Get", "List", "Describe"))
    is_unset = not is_read and any(word in name for word in UNSET.get(service, "").split())
    return service not in UNUSED and not is_unset


def handler_actions(kind: str) -> set[str]:
    """Actions of CloudFormation's handlers for a type of resource, by AWS's schemas, which cfn-lint has."""
    package = importlib.util.find_spec("cfnlint")
    assert package is not None
    assert package.origin is not None
    schemas = Path(package.origin).parent / "data" / "schemas"
    names = json.loads((schemas / "providers" / "us-east-1.json").read_text())
    handlers = json.loads((schemas / "resources" / f"{names[kind]}.json").read_text()).get("handlers", {})
    needed = (handler["permissions"] for name, handler in handlers.items() if name != "list")
    return {action for actions in needed for action in actions}


def test_no_version_of_an_object_can_be_removed() -> None:
    assert not [a for a in ALLOWED if fnmatch.fnmatchcase("s3:DeleteObjectVersion", a)]
    removing = [s for s in STATEMENTS if "s3:DeleteObject" in s["Action"]]
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
    allowed = {a for s in BOUNDARY["PolicyDocument"]["Statement"] for a in s["Action"]}
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
        if statement["Effect"] == "Allow" and (actions := granting & set(statement["Action"])):
            required = statement["Condition"]["StringEquals"]["iam:PermissionsBoundary"]["Fn::Sub"]
            assert required.endswith(f":policy/{boundary}"), statement["Sid"]
            found |= actions
    assert found == granting
    denied = BY_SID["NotItself"]["Resource"]
    assert any(resource["Fn::Sub"].endswith(f":policy/{boundary}") for resource in denied)
    assert "iam:DeleteRolePermissionsBoundary" not in ALLOWED


def test_policies_fit_into_iam() -> None:
    for name, policy in POLICIES.items():
        text = json.dumps(policy["PolicyDocument"], separators=(",", ":"))
        # The longest partition, account and region that a `!Sub` may stand for are no longer than itself.
        size = len(re.sub(r'\{"Fn::Sub":("[^"]*")\}', r"\1", text))
        assert size <= 6144, name  # IAM quotas, "managed policy size", whitespace not counted
