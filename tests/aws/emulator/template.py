"""Resources of `template.yaml`, read for running them in one process.

Nothing that the template names is named again here: functions, routes, tables and buckets exist because the
template lists them. Only what an offline stack needs is resolved; an intrinsic function it does not know is
an error, never a guess.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from infra.deploy.template import parse_text
from tests.aws.emulator.intrinsics import Resolver, TemplateError, text


@dataclass(frozen=True)
class FunctionSpec:
    """One `AWS::Serverless::Function`, Globals merged in."""

    name: str
    """Logical id; locally it is also the name it is invoked by."""
    code: Path
    handler: str
    """`module.attribute`, as Lambda writes it."""
    timeout: float
    """Seconds."""
    memory: int
    """MB; only reported to the handler."""
    environment: Mapping[str, str]
    retries: int
    """Retries of an asynchronous invocation that failed."""
    failures: str | None = None
    """Name of the dead-letter queue; None: there is none."""


@dataclass(frozen=True)
class RouteSpec:
    """One `HttpApi` event: which function answers this method and path."""

    method: str
    path: str
    function: str


@dataclass(frozen=True)
class CorsSpec:
    """The HTTP API's `CorsConfiguration`."""

    allow_origins: tuple[str, ...] = ()
    allow_methods: tuple[str, ...] = ()
    allow_headers: tuple[str, ...] = ()
    expose_headers: tuple[str, ...] = ()
    max_age: int | None = None


@dataclass(frozen=True)
class TableSpec:
    """One `AWS::DynamoDB::Table`."""

    name: str
    properties: Mapping[str, Any]


@dataclass(frozen=True)
class Template:
    """All of a template that a local stack needs."""

    functions: Mapping[str, FunctionSpec]
    routes: tuple[RouteSpec, ...]
    cors: CorsSpec | None
    tables: tuple[TableSpec, ...]
    buckets: tuple[str, ...]

    def environment(self) -> dict[str, str]:
        """Merge the variables of all functions.

        Lambda gives each function an environment of its own; here they share one process. So two functions
        may lack each other's variables but may not disagree about one.

        Raises
        ------
        TemplateError
            If two functions give one variable different values.
        """
        union: dict[str, str] = {}
        owner: dict[str, str] = {}
        for function in self.functions.values():
            for variable, value in function.environment.items():
                if union.setdefault(variable, value) != value:
                    raise TemplateError(
                        f"{function.name} and {owner[variable]} give {variable} different values; "
                        "in one process they share it"
                    )
                owner.setdefault(variable, function.name)
        return union


def load(path: Path, parameters: Mapping[str, str]) -> Template:
    """Read a SAM template.

    Parameters
    ----------
    path
        The template; paths in it are relative to its folder.
    parameters
        Values for the template's parameters, over their defaults. One that the template lacks is ignored.

    Raises
    ------
    TemplateError
        If a parameter without default has no value, or something cannot be resolved.
    """
    document = _document(path.read_text(encoding="utf-8"))
    resources: Mapping[str, Any] = document["Resources"]
    resolve = Resolver(_values(document.get("Parameters", {}), parameters), resources)
    globals_ = document.get("Globals", {})
    root = path.resolve().parent

    functions: dict[str, FunctionSpec] = {}
    routes: list[RouteSpec] = []
    tables: list[TableSpec] = []
    buckets: list[str] = []
    cors: CorsSpec | None = None
    for name, resource in resources.items():
        properties = resource.get("Properties", {})
        match resource["Type"]:
            case "AWS::Serverless::Function":
                merged = _merge(globals_.get("Function", {}), properties)
                functions[name] = _function(name, merged, root, resolve)
                routes += _routes(name, merged, resolve)
            case "AWS::Serverless::HttpApi":
                merged = _merge(globals_.get("HttpApi", {}), properties)
                cors = _cors(resolve(merged.get("CorsConfiguration")))
            case "AWS::DynamoDB::Table":
                tables.append(TableSpec(resolve({"Ref": name}), resolve(properties)))
            case "AWS::S3::Bucket":
                buckets.append(resolve({"Ref": name}))
    return Template(functions, tuple(routes), cors, tuple(tables), tuple(buckets))


@functools.lru_cache(maxsize=4)
def _document(template: str) -> Mapping[str, Any]:
    """Parse a template, once for all stacks of a process: nothing here changes what was parsed."""
    return parse_text(template)


def _function(name: str, properties: Mapping[str, Any], root: Path, resolve: Resolver) -> FunctionSpec:
    variables = resolve(properties.get("Environment", {}).get("Variables", {}))
    later = resolve(properties.get("EventInvokeConfig", {}))
    failures = later.get("DestinationConfig", {}).get("OnFailure", {}).get("Destination")
    return FunctionSpec(
        name=name,
        code=root / properties["CodeUri"],
        handler=properties["Handler"],
        timeout=float(properties.get("Timeout", 3)),
        memory=int(properties.get("MemorySize", 128)),
        environment={key: text(value) for key, value in variables.items()},
        retries=int(later.get("MaximumRetryAttempts", 2)),
        failures=failures and str(failures).rpartition(":")[2],
    )


def _routes(function: str, properties: Mapping[str, Any], resolve: Resolver) -> Iterable[RouteSpec]:
    for event in properties.get("Events", {}).values():
        if event["Type"] == "HttpApi":
            route = resolve(event["Properties"])
            yield RouteSpec(route["Method"].upper(), route["Path"], function)


def _cors(configuration: Any) -> CorsSpec | None:
    if not isinstance(configuration, Mapping):
        return CorsSpec(("*",), ("*",), ("*",)) if configuration is True else None
    return CorsSpec(
        allow_origins=tuple(configuration.get("AllowOrigins", ())),
        allow_methods=tuple(configuration.get("AllowMethods", ())),
        allow_headers=tuple(configuration.get("AllowHeaders", ())),
        expose_headers=tuple(configuration.get("ExposeHeaders", ())),
        max_age=configuration.get("MaxAge"),
    )


def _values(declared: Mapping[str, Any], given: Mapping[str, str]) -> dict[str, Any]:
    values = {}
    for name, parameter in declared.items():
        if name in given:
            values[name] = given[name]
        elif "Default" in parameter:
            values[name] = parameter["Default"]
        else:
            raise TemplateError(f"the template's parameter {name} has neither a value nor a default")
    return values


def _merge(base: Any, own: Any) -> Any:
    """Merge Globals into a resource as SAM does: maps merge, lists concatenate, the rest is replaced.

    Source: AWS SAM developer guide, "Globals section of the AWS SAM template", overridable properties.
    """
    if isinstance(base, Mapping) and isinstance(own, Mapping):
        both = {key: _merge(base[key], own[key]) if key in own else base[key] for key in base}
        return both | {key: value for key, value in own.items() if key not in base}
    if isinstance(base, list) and isinstance(own, list):
        return base + own
    return own
