"""CloudFormation templates as YAML: short forms such as `!Ref X` become their long forms."""

import re
from pathlib import Path
from typing import Any

import yaml


def parse(path: Path) -> dict[str, Any]:
    """Parse a template; the `Routes` of its functions become their events, each with a rate."""
    document: dict[str, Any] = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)  # noqa: S506
    resources = document["Resources"]
    for resource in resources.values():
        routes = resource.get("Properties", {}).pop("Routes", None)
        if routes:
            rates = resources["HttpApi"]["Properties"]["RouteSettings"]
            resource["Properties"]["Events"] = _events(routes, rates)
    return document


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
    if suffix == "GetAtt" and isinstance(value, str):
        value = value.split(".", 1)
    return {suffix if suffix in ("Ref", "Condition") else f"Fn::{suffix}": value}


_Loader.add_multi_constructor("!", _short_form)
