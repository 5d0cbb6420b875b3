"""CloudFormation templates as YAML: short forms such as `!Ref X` become their long forms.

Some short forms are ours:

* `!Arn "service:region:own:resource"` is an ARN of this partition, of the stack's account for `own`.
* `!Policy` makes the document of a list of statements. In these `service: One Two` names actions, `Allow` is
  the effect by default, and `Keys`, `Attributes` and `Prefixes` are conditions. With `Attributes`, values of
  others are not returned.
* `Policies`, next to `Resources`, are the statements of managed policies; `NamedPolicies` have their names
  behind the stack's.
* `Routes` of a function become its events.
"""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

# Operators and names of conditions, for partition keys and attributes of items, and for names of objects
_CONDITIONS = {
    "Keys": ("ForAllValues:StringLike", "dynamodb:LeadingKeys"),
    "Attributes": ("ForAllValues:StringEquals", "dynamodb:Attributes"),
    "Prefixes": ("StringLike", "s3:prefix"),
}


def parse(path: Path) -> dict[str, Any]:
    """Parse a template, and expand its short forms."""
    document: dict[str, Any] = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)  # noqa: S506
    resources = document.setdefault("Resources", {})
    for name, statements in document.pop("Policies", {}).items():
        resources[name] = _policy(statements)
    for name, statements in document.pop("NamedPolicies", {}).items():
        full_name = {"Fn::Sub": f"${{Stack}}-{name}"}
        resources[name.title().replace("-", "")] = _policy(statements, ManagedPolicyName=full_name)
    for resource in resources.values():
        properties = resource.get("Properties", {})
        if "Routes" in properties:
            rates = resources["HttpApi"]["Properties"]["RouteSettings"]
            properties["Events"] = _events(properties.pop("Routes"), rates)
    return document


def _policy(statements: list[dict[str, Any]], **properties: Any) -> dict[str, Any]:
    properties["PolicyDocument"] = _document(statements)
    return {"Type": "AWS::IAM::ManagedPolicy", "Properties": properties}


def _document(statements: list[dict[str, Any]]) -> dict[str, Any]:
    return {"Version": "2012-10-17", "Statement": [_statement(each) for each in statements]}


def _statement(short: Mapping[str, Any]) -> dict[str, Any]:
    """Expand a statement: its keys in lower case are services, with the names of their actions."""
    services = {key: names for key, names in short.items() if key.islower()}
    actions = [f"{service}:{name}" for service, names in services.items() for name in names.split()]
    others = {key: value for key, value in short.items() if key not in {*services, *_CONDITIONS}}
    conditions = dict(others.pop("Condition", {}))
    for key, (operator, name) in _CONDITIONS.items():
        if key in short:
            conditions[operator] = {name: short[key]}
    if "Attributes" in short:
        conditions["StringEqualsIfExists"] = {"dynamodb:ReturnValues": ["NONE", "UPDATED_NEW"]}
    statement = {"Effect": "Allow", "Action": actions, **others}
    return statement | ({"Condition": conditions} if conditions else {})


def _events(routes: list[str], rates: dict[str, Any]) -> dict[str, Any]:
    """Make the events of a function's routes; routes without a rate get that of computations.

    Every path also has an ANY route, so that a wrong method reaches the function and gets 405 with Allow. An
    HTTP API would answer 404.
    """
    rate = {"Ref": "ComputeRate"}
    events = {}
    for route in dict.fromkeys([*routes, *(f"ANY {route.partition(' ')[2]}" for route in routes)]):
        method, path = route.split(" ")
        rates.setdefault(route, {"ThrottlingRateLimit": rate, "ThrottlingBurstLimit": rate})
        properties = {"ApiId": {"Ref": "HttpApi"}, "Method": method, "Path": path}
        events[re.sub(r"\W", "", route)] = {"Type": "HttpApi", "Properties": properties}
    return events


class _Loader(yaml.CSafeLoader):
    """libyaml's loader, as the template is read at each start of a stack."""


def _short_form(loader: _Loader, suffix: str, node: Any) -> dict[str, Any]:
    value: Any
    if isinstance(node, yaml.MappingNode):
        value = loader.construct_mapping(node, deep=True)
    elif isinstance(node, yaml.SequenceNode):
        value = loader.construct_sequence(node, deep=True)
    else:
        value = loader.construct_scalar(node)
    if suffix == "Policy":
        return _document(value)
    if suffix == "Arn":
        return {"Fn::Sub": "arn:${AWS::Partition}:" + value.replace(":own:", ":${AWS::AccountId}:")}
    if suffix == "GetAtt" and isinstance(value, str):
        value = value.split(".", 1)
    return {suffix if suffix in ("Ref", "Condition") else f"Fn::{suffix}": value}


_Loader.add_multi_constructor("!", _short_form)
