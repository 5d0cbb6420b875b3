"""IAM's rules as far as the template uses them, and a record of what each function asks of AWS."""

import contextvars
import fnmatch
import functools
import json
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import pytest
from botocore.client import BaseClient

from tests.aws.emulator.functions import Function
from tests.aws.emulator.intrinsics import ACCOUNT, REGION, Resolver
from tests.helpers.data import ROOT
from tests.helpers.sam import complete

running: contextvars.ContextVar[str | None] = contextvars.ContextVar("running", default=None)
# Operations that are granted under another name than their own.
_ACTIONS = {"invoke": "InvokeFunction", "delete_objects": "DeleteObject", "transact_write_items": "PutItem"}


@dataclass(frozen=True)
class Needed:
    action: str
    resource: str
    keys: frozenset[str] = frozenset()  # DynamoDB's leading keys
    attributes: frozenset[str] | None = None  # that a write touches; None where it names none
    returned: str | None = None  # ReturnValues
    prefix: str | None = None  # of what is listed


@dataclass(frozen=True)
class Grant:
    sid: str
    actions: tuple[str, ...]
    resources: tuple[str, ...]
    conditions: Mapping[str, Mapping[str, Any]]

    def allows(self, needed: Needed) -> bool:
        return (
            needed.action in self.actions
            and any(fnmatch.fnmatchcase(needed.resource, pattern) for pattern in self.resources)
            and all(
                _meets(needed, kind, name, allowed)
                for kind, tests in self.conditions.items()
                for name, allowed in tests.items()
            )
        )

    @property
    def attributes(self) -> frozenset[str]:
        return frozenset(self.conditions.get("ForAllValues:StringEquals", {}).get("dynamodb:Attributes", ()))


def _meets(needed: Needed, kind: str, name: str, allowed: Any) -> bool:
    def is_like(value: str) -> bool:
        return any(fnmatch.fnmatchcase(value, pattern) for pattern in allowed)

    match kind, name:
        case "ForAllValues:StringLike", "dynamodb:LeadingKeys":
            return all(map(is_like, needed.keys))
        case "ForAllValues:StringEquals", "dynamodb:Attributes":
            return (needed.attributes or frozenset()) <= set(allowed)
        case "StringEqualsIfExists", "dynamodb:ReturnValues":
            return needed.returned is None or needed.returned in allowed
        case "StringLike", "s3:prefix":
            return is_like(needed.prefix or "")
    raise AssertionError(f"a condition that is not known here: {kind} {name}")


def listed(value: Any) -> tuple[Any, ...]:
    return tuple(value) if isinstance(value, list) else (value,)


@functools.cache
def grants(kind: str = "AWS::Serverless::Function") -> dict[str, tuple[Grant, ...]]:
    """Permissions that the template grants each resource of this type that is always deployed."""
    document, resolve = template()

    def grant(statement: Mapping[str, Any]) -> Grant:
        resources = tuple(map(resolve, listed(statement["Resource"])))
        actions = listed(statement["Action"])
        return Grant(statement["Sid"], actions, resources, statement.get("Condition", {}))

    return {
        name: tuple(map(grant, statements(document, resource["Properties"])))
        for name, resource in document["Resources"].items()
        if resource["Type"] == kind and "Condition" not in resource
    }


def statements(document: Mapping[str, Any], properties: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    for policy in properties["Policies"]:
        if "Ref" in policy:
            policy = document["Resources"][policy["Ref"]]["Properties"]["PolicyDocument"]
        yield from policy["Statement"]


@functools.cache
def template() -> tuple[Mapping[str, Any], Resolver]:
    document = complete()
    defaults = {n: p.get("Default", "") for n, p in document["Parameters"].items()}
    return document, Resolver(defaults, document["Resources"])


def needs_of_machine(name: str) -> Iterator[Needed]:
    """Permissions that a state machine needs by its definition, which nothing here can run.

    Sources: AWS Step Functions developer guide, "IAM policies for using Distributed Map states" and "AWS
    Lambda". A distributed map starts the machine itself anew for each batch, and follows what it started.
    """
    document, resolve = template()
    machine = document["Resources"][name]["Properties"]
    named = {k: resolve(v) for k, v in machine["DefinitionSubstitutions"].items()}
    own = f"{ACCOUNT}:{{}}:{resolve(machine['Name'])}"
    definition = json.loads((ROOT / machine["DefinitionUri"]).read_text())
    for state in _states(definition):
        asked = {k: str(v).strip("${}") for k, v in state.get("Parameters", {}).items()}
        if "ItemReader" in state:
            listed_there = state["ItemReader"]["Parameters"]
            bucket = named[listed_there["Bucket"].strip("${}")]
            yield Needed("s3:ListBucket", f"arn:aws:s3:::{bucket}", prefix=listed_there["Prefix"])
        if state.get("ItemProcessor", {}).get("ProcessorConfig", {}).get("Mode") == "DISTRIBUTED":
            yield Needed("states:StartExecution", f"arn:aws:states:{REGION}:{own.format('stateMachine')}")
            children = f"arn:aws:states:{REGION}:{own.format('execution')}"
            for action in ("DescribeExecution", "StopExecution"):
                yield Needed(f"states:{action}", f"{children}:0123abcd")
            yield Needed("states:RedriveExecution", f"{children}/EveryCalibration:0123abcd")
        if state["Type"] == "Task":
            assert state["Resource"] == "arn:aws:states:::lambda:invoke", state
            function = named[asked["FunctionName"]]
            yield Needed("lambda:InvokeFunction", f"arn:aws:lambda:{REGION}:{ACCOUNT}:function:{function}")


def _states(definition: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    for state in definition["States"].values():
        yield state
        if "ItemProcessor" in state:
            yield from _states(state["ItemProcessor"])


def needs(service: str, operation: str, asked: Mapping[str, Any]) -> Iterator[Needed]:
    """Permission that a call with these parameters needs."""
    action = _ACTIONS.get(operation) or "".join(word.title() for word in operation.split("_"))
    match service:
        case "lambda":
            function = f"arn:aws:lambda:{REGION}:{ACCOUNT}:function:{asked['FunctionName']}"
            yield Needed(f"lambda:{action}", function)
        case "s3" if operation == "list_objects_v2":
            yield Needed("s3:ListBucket", f"arn:aws:s3:::{asked['Bucket']}", prefix=asked["Prefix"])
        case "s3":
            objects = asked["Delete"]["Objects"] if "Delete" in asked else [asked]
            for place in (f"arn:aws:s3:::{asked['Bucket']}/{each['Key']}" for each in objects):
                yield Needed(f"s3:{action}", place)
                if "IfMatch" in asked:  # S3 reads what it compares with
                    yield Needed("s3:GetObject", place)
        case "dynamodb":
            for part in [w["Put"] for w in asked["TransactItems"]] if "TransactItems" in asked else [asked]:
                yield Needed(
                    f"dynamodb:{action}",
                    f"arn:aws:dynamodb:{REGION}:{ACCOUNT}:table/{part['TableName']}",
                    frozenset({_key(part)}),
                    frozenset(_attributes(part)) if operation == "update_item" else None,
                    part.get("ReturnValues"),
                )
        case _:
            raise AssertionError(f"a service that is not known here: {service}")


def _key(asked: Mapping[str, Any]) -> str:
    key = asked.get("Key") or asked.get("Item")
    if key is not None:
        return str(key["pk"]["S"])
    assert asked["KeyConditionExpression"].startswith("pk = :pk ")
    return str(asked["ExpressionAttributeValues"][":pk"]["S"])


def _attributes(asked: Mapping[str, Any]) -> Iterator[str]:
    yield from asked["Key"]
    yield from asked["ExpressionAttributeNames"].values()


@contextmanager
def recording() -> Iterator[Mapping[str, set[Needed]]]:
    """Yield what functions ask of AWS within the block, by function."""
    needed: defaultdict[str, set[Needed]] = defaultdict(set)
    call = BaseClient._make_api_call

    def recorded(client: Any, operation: str, asked: Mapping[str, Any]) -> Any:
        who = running.get()
        if who is not None:
            name = next(n for n, o in client.meta.method_to_api_mapping.items() if o == operation)
            needed[who] |= set(needs(client.meta.service_model.service_name, name, asked))
        return call(client, operation, asked)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Function, "__call__", _named(Function.__call__))
        patch.setattr(BaseClient, "_make_api_call", recorded)
        patch.setattr(ThreadPoolExecutor, "submit", _inherited(ThreadPoolExecutor.submit))
        yield needed


def _named(call: Callable[..., Any]) -> Callable[..., Any]:
    def named(function: Function, *arguments: Any) -> Any:
        before = running.set(function.spec.name)
        try:
            return call(function, *arguments)
        finally:
            running.reset(before)

    return named


def _inherited(submit: Callable[..., Any]) -> Callable[..., Any]:
    def inherited(
        pool: ThreadPoolExecutor, task: Callable[..., Any], /, *arguments: Any, **named: Any
    ) -> Any:
        return submit(pool, contextvars.copy_context().run, task, *arguments, **named)

    return inherited
