"""Calls of a deployment to AWS's API. All of them are idempotent."""

import json
import secrets
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import boto3
from botocore.exceptions import BotoCoreError, ClientError

from infra.deploy.site import Upload

# EDGE_SECRETS are all that functions accept from the edge; EDGE_SECRET is the one that CloudFront sends.
SECRETS = ("SESSION_SECRETS", "CONTRIBUTOR_SECRET", "EDGE_SECRETS", "EDGE_SECRET")
# CloudFormation reads this one for CloudFront's header, and of secure ones it can read none there.
_READ_BY_CLOUDFORMATION = "EDGE_SECRET"
_INLINE = ("Probe", "CutoffFunction")  # their code stands in the template: they belong to no release
FUNCTION, ALIAS = "AWS::Lambda::Function", "AWS::Lambda::Alias"
UNCREATED = ("", "REVIEW_IN_PROGRESS", "DELETE_COMPLETE")  # status of a stack that has no resources


class DeployError(RuntimeError):
    """The deployment failed; the message says where."""


@dataclass(frozen=True)
class Stack:
    """A stack as CloudFormation describes it."""

    status: str
    parameters: Mapping[str, str]
    outputs: Mapping[str, str]


@dataclass(frozen=True)
class Account:
    """The account in which a stack is or will be: the calls of a deployment for the stack."""

    stack: str
    region: str
    clients: dict[str, Any] = field(default_factory=dict)  # by service, made when they are needed

    def client(self, service: str) -> Any:
        """Return the client of a service of AWS."""
        if service not in self.clients:
            make: Any = boto3.client  # whose types know only literal names
            # CloudFront takes certificates of us-east-1.
            self.clients[service] = make(service, "us-east-1" if service == "acm" else self.region)
        return self.clients[service]

    @property
    def _cloudformation(self) -> Any:
        return self.client("cloudformation")

    def describe(self) -> Stack:
        """Read the stack; without status, parameters and outputs if there is none."""
        try:
            (description,) = self._cloudformation.describe_stacks(StackName=self.stack)["Stacks"]
        except ClientError as error:
            if error.response["Error"]["Code"] == "ValidationError":
                return Stack("", {}, {})
            raise
        return Stack(
            description["StackStatus"],
            {p["ParameterKey"]: p["ParameterValue"] for p in description.get("Parameters", ())},
            {o["OutputKey"]: o["OutputValue"] for o in description.get("Outputs", ())},
        )

    def make_secrets(self) -> list[str]:
        """Make the missing secrets, without replacing any; return their names."""
        response = self.client("ssm").get_parameters(
            Names=[f"/calibdb/{self.stack}/{name}" for name in SECRETS]
        )
        there = {p["Name"].rpartition("/")[2] for p in response["Parameters"]}
        missing = [name for name in SECRETS if name not in there]
        for name in missing:
            if name == _READ_BY_CLOUDFORMATION:  # after the list, whose first it is
                keys = self._read("EDGE_SECRETS")[:1]
            elif name == "EDGE_SECRETS" and _READ_BY_CLOUDFORMATION not in missing:  # CloudFront sends it
                keys = [*self._read(_READ_BY_CLOUDFORMATION), secrets.token_hex(32)]
            else:
                keys = [secrets.token_hex(32) for _ in range(1 if name == "CONTRIBUTOR_SECRET" else 2)]
            self._write(name, keys, overwrite=False)
        return missing

    def rotate(self, name: str = "SESSION_SECRETS") -> list[str]:
        """Make of the keys `current, next, before` the keys `next, new, current`; return them.

        Every function knows the next key before it signs, so none refuses what another has signed while they
        learn of the rotation, within five minutes.
        """
        current, *following = self._read(name)[:2]
        new = secrets.token_hex(32)
        keys = [*following, new, current] if following else [current, new]
        self._write(name, keys, overwrite=True)
        return keys

    def rotate_edge(self) -> int:
        """Rotate the secrets of the edge alike; return the version of EDGE_SECRET that CloudFront is to send.

        CloudFront reads it only when its distribution changes. Until then functions accept the previous one.
        """
        self._write(_READ_BY_CLOUDFORMATION, self.rotate("EDGE_SECRETS")[:1], overwrite=True)
        return self.edge_secret_version()

    def edge_secret_version(self) -> int:
        """Read the version of EDGE_SECRET."""
        response = self.client("ssm").get_parameter(Name=f"/calibdb/{self.stack}/{_READ_BY_CLOUDFORMATION}")
        return int(response["Parameter"]["Version"])

    def set_parameter(self, name: str, value: str) -> None:
        """Change one parameter of the stack and wait until that is done."""
        self._cloudformation.update_stack(
            StackName=self.stack,
            UsePreviousTemplate=True,
            Capabilities=["CAPABILITY_IAM", "CAPABILITY_AUTO_EXPAND"],
            Parameters=[
                {"ParameterKey": key, "ParameterValue": value}
                if key == name
                else {"ParameterKey": key, "UsePreviousValue": True}
                for key in self.describe().parameters
            ],
        )
        self._cloudformation.get_waiter("stack_update_complete").wait(StackName=self.stack)

    def _read(self, name: str) -> list[str]:
        response = self.client("ssm").get_parameter(Name=f"/calibdb/{self.stack}/{name}", WithDecryption=True)
        value: str = response["Parameter"]["Value"]
        return value.split(",")

    def _write(self, name: str, keys: list[str], *, overwrite: bool) -> None:
        self.client("ssm").put_parameter(
            Name=f"/calibdb/{self.stack}/{name}",
            Value=",".join(keys),
            Type="String" if name == _READ_BY_CLOUDFORMATION else "SecureString",
            Overwrite=overwrite,
        )

    def outputs(self) -> Mapping[str, str]:
        """Read the stack's outputs by name."""
        return self.describe().outputs

    def resources(self, kind: str | None = None) -> list[Mapping[str, str]]:
        """Read the resources of the stack, of one type or of all."""
        pages = self._cloudformation.get_paginator("list_stack_resources").paginate(StackName=self.stack)
        every = [resource for page in pages for resource in page["StackResourceSummaries"]]
        return [resource for resource in every if kind in (None, resource["ResourceType"])]

    def versions(self, function: str) -> list[int]:
        """Read the numbers of a function's published versions."""
        paginator = self.client("lambda").get_paginator("list_versions_by_function")
        pages = paginator.paginate(FunctionName=function)
        numbers = [version["Version"] for page in pages for version in page["Versions"]]
        return [int(number) for number in numbers if number.isdecimal()]

    def releases(self) -> dict[str, str]:
        """Read the release of each function: at its alias `live` if it has one, else as it is invoked."""
        aliases, lambda_ = self.resources(ALIAS), self.client("lambda")
        aliased = {alias["PhysicalResourceId"].split(":")[-2] for alias in aliases}
        result = {}
        for function in self.resources(FUNCTION):
            if function["LogicalResourceId"] in _INLINE:
                continue
            name = function["PhysicalResourceId"]
            qualifier = {"Qualifier": "live"} if name in aliased else {}
            configuration = lambda_.get_function_configuration(FunctionName=name, **qualifier)
            result[name] = configuration.get("Environment", {}).get("Variables", {}).get("RELEASE", "")
        return result

    def step_back(self) -> dict[str, tuple[str, str]]:
        """Point each alias of the stack at the version before its own; return both versions by function.

        A function without an earlier version stays. Run again, it goes back one more version.
        """
        moved, lambda_ = {}, self.client("lambda")
        for arn in sorted(alias["PhysicalResourceId"] for alias in self.resources(ALIAS)):
            function, name = arn.split(":")[-2:]
            current = int(lambda_.get_alias(FunctionName=function, Name=name)["FunctionVersion"])
            earlier = max((n for n in self.versions(function) if n < current), default=None)
            if earlier is None:
                continue
            lambda_.update_alias(
                FunctionName=function,
                Name=name,
                FunctionVersion=str(earlier),
                RoutingConfig={"AdditionalVersionWeights": {}},
            )
            moved[function] = str(current), str(earlier)
        return moved

    def failures(self) -> list[str]:
        """Read why resources of the newest stack of this name failed, also of one that was deleted since."""
        try:
            pages = self._cloudformation.get_paginator("list_stacks").paginate()
            named = [s for page in pages for s in page["StackSummaries"] if s["StackName"] == self.stack]
            newest = max(named, key=lambda s: s["CreationTime"])
            events = self._cloudformation.describe_stack_events(StackName=newest["StackId"])["StackEvents"]
        except (ClientError, BotoCoreError, ValueError):
            return []  # the command itself said more
        return [
            f"{e['LogicalResourceId']}: {e.get('ResourceStatusReason', '')}"
            for e in events
            if e["ResourceStatus"].endswith("_FAILED")
        ]

    def invalidate(self) -> None:
        """Empty the edge's caches."""
        self.client("cloudfront").create_invalidation(
            DistributionId=self.outputs()["DistributionId"],
            InvalidationBatch={
                "Paths": {"Quantity": 1, "Items": ["/*"]},
                "CallerReference": str(time.time_ns()),
            },
        )

    def protect(self) -> None:
        """Protect stack and table from deletion.

        Not in the template: a creation that fails must be able to delete them.
        """
        self._cloudformation.update_termination_protection(
            StackName=self.stack, EnableTerminationProtection=True
        )
        table, dynamodb = self.outputs()["TableName"], self.client("dynamodb")
        if not dynamodb.describe_table(TableName=table)["Table"].get("DeletionProtectionEnabled"):
            dynamodb.update_table(TableName=table, DeletionProtectionEnabled=True)


def upload(s3: Any, bucket: str, files: Iterable[Upload]) -> int:
    """Upload the files in their order; return how many.

    A versioned file that exists stays, and DeployError is raised if its content differs. An initial file
    gives way to any object of its name.
    """
    number = 0
    for number, file in enumerate(files, 1):  # noqa: B007 - how many there were
        published = _content(s3, bucket, file.key) if file.is_versioned else None
        if published not in (None, file.content):
            message = f"{file.key} is published with another content: raise the version (`make release`)"
            raise DeployError(message)
        if published is not None:
            continue
        more = {"ContentEncoding": file.content_encoding} if file.content_encoding else {}
        more |= {"IfNoneMatch": "*"} if file.is_initial else {}
        try:
            s3.put_object(
                Bucket=bucket,
                Key=file.key,
                Body=file.content,
                ContentType=file.content_type,
                CacheControl=file.cache_control,
                **more,
            )
        except ClientError as error:
            if not (file.is_initial and error.response["Error"]["Code"] == "PreconditionFailed"):
                raise
    return number


def settings(s3: Any, bucket: str) -> Mapping[str, str]:
    """Read the deployed `/config.json`; empty if there is none."""
    result: Mapping[str, str] = json.loads(_content(s3, bucket, "config.json") or "{}")
    return result


def _content(s3: Any, bucket: str, key: str) -> bytes | None:
    """Read an object, None if there is none; S3 says so to those who may list the bucket."""
    try:
        content: bytes = s3.get_object(Bucket=bucket, Key=key)["Body"].read()
    except s3.exceptions.NoSuchKey:
        return None
    return content
