"""Resources of `template.yaml`, read for running them in one process.

Functions, routes, tables and buckets exist because the template lists them. An unknown intrinsic function is
an error, never a guess.
"""

import functools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from infra.deploy.template import parse
from tests.aws.emulator.intrinsics import Resolver, text
from tests.helpers.data import ROOT

_parsed = functools.cache(parse)  # for all stacks of a process: nothing changes it


@dataclass(frozen=True)
class FunctionSpec:
    """One `AWS::Serverless::Function`, Globals merged in."""

    name: str  # logical id; locally also the name by which it is invoked
    module: str
    timeout: float  # s
    memory: int  # MB
    environment: Mapping[str, str]


@dataclass(frozen=True)
class RouteSpec:
    """One `HttpApi` event: which function answers this method and path."""

    method: str
    path: str
    function: str

    @property
    def key(self) -> str:
        """The `routeKey` of the event."""
        return f"{self.method} {self.path}"


@dataclass(frozen=True)
class Template:
    """All of a template that a local stack needs."""

    functions: Mapping[str, FunctionSpec]
    routes: tuple[RouteSpec, ...]
    cors: Mapping[str, Any]  # `CorsConfiguration` of the HTTP API
    tables: Mapping[str, Mapping[str, Any]]  # properties by name
    buckets: tuple[str, ...]

    def environment(self) -> dict[str, str]:
        """Merge the variables of all functions, which share one process here."""
        union: dict[str, str] = {}
        for function in self.functions.values():
            for variable, value in function.environment.items():
                assert union.setdefault(variable, value) == value, (function.name, variable)
        return union


def load(parameters: Mapping[str, str]) -> Template:
    """Read the template; `parameters` replace defaults. Raises ValueError if it cannot be resolved."""
    document = _parsed(ROOT / "template.yaml")
    resources: Mapping[str, Any] = document["Resources"]
    defaults = {name: declared.get("Default") for name, declared in document["Parameters"].items()}
    resolve = Resolver(defaults | dict(parameters), resources)
    functions: dict[str, FunctionSpec] = {}
    routes: list[RouteSpec] = []
    tables: dict[str, Mapping[str, Any]] = {}
    buckets: list[str] = []
    cors: Mapping[str, Any] = {}
    for name, resource in resources.items():
        properties = resource.get("Properties", {})
        match resource["Type"]:
            case "AWS::Serverless::Function":
                functions[name] = _function(name, document["Globals"]["Function"], properties, resolve)
                routes += _routes(name, properties, resolve)
            case "AWS::Serverless::HttpApi":
                cors = resolve(properties["CorsConfiguration"])
            case "AWS::DynamoDB::Table":
                tables[resolve({"Ref": name})] = resolve(properties)
            case "AWS::S3::Bucket":
                buckets.append(resolve({"Ref": name}))
    return Template(functions, tuple(routes), cors, tables, tuple(buckets))


def _function(
    name: str, shared: Mapping[str, Any], own: Mapping[str, Any], resolve: Resolver
) -> FunctionSpec:
    variables = shared["Environment"]["Variables"] | own.get("Environment", {}).get("Variables", {})
    properties = {**shared, **own}
    return FunctionSpec(
        name=name,
        module=f"{properties['CodeUri'].strip('/').replace('/', '.')}.app",
        timeout=float(properties["Timeout"]),
        memory=int(properties["MemorySize"]),
        environment={key: text(value) for key, value in resolve(variables).items()},
    )


def _routes(function: str, properties: Mapping[str, Any], resolve: Resolver) -> Iterable[RouteSpec]:
    for event in properties.get("Events", {}).values():
        if event["Type"] == "HttpApi":
            route = resolve(event["Properties"])
            yield RouteSpec(route["Method"].upper(), route["Path"], function)
