"""One call of the API: its parameters, its contents, and its problems.

Parameters of a query are generated from the pydantic models that the functions parse queries with.
"""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from pydantic import AliasChoices, BaseModel

from calibdb.http.call import MAX_BODY_BYTES

_TEXTS = Path(__file__).resolve().parents[2] / "web" / "templates" / "docs"
Node = dict[str, Any]
JSON, PROBLEM, JPEG, PNG = "application/json", "application/problem+json", "image/jpeg", "image/png"
SVG = "image/svg+xml"

TAGS = {
    "Lookup": "Find the calibration of a camera.",
    "Capture": "Calibrate a camera, view by view. The guidance page makes these calls; any client can.",
    "Rigs": "Calibrate several fixed cameras together, each from its own client.",
    "Database": "Search cameras, read stored calibrations, write them as another tool's file.",
    "Tokens": "Create and manage API tokens. Anyone can create one.",
    "Service": "State of the service.",
}
"""Groups of calls, in the order of the reference."""
_GROUPS = {
    "/v1/lookup": "Lookup",
    "/known/": "Lookup",
    "/v1/rigs": "Rigs",
    "/v1/tokens": "Tokens",
    "/v1/usage": "Tokens",
    "/healthz": "Service",
    "/v1/auth": "Capture",
    "/v1/session": "Capture",
    "/v1/checks": "Capture",
}
"""Groups by the beginnings of paths; all other calls are of the database."""

TOKEN = "cdb_dev_local"  # noqa: S105 - that of local stacks; pages put the visitor's in its place
CREDENTIALS = {"apiToken": TOKEN, "sessionId": "SESSION_ID", "managementToken": "MANAGEMENT_TOKEN"}
"""Placeholders of credentials in examples, by their names in the OpenAPI document."""

PROBLEMS = {
    400: "The body is not JSON.",
    401: "No credential was sent.",
    403: "The credential is unknown, expired, or not for this origin.",
    404: "The resource does not exist.",
    406: "None of the accepted media types is available.",
    409: "The request conflicts with the current state.",
    410: "The calibration was withdrawn; `reason` is wrong, abuse, privacy or other.",
    413: f"The body is larger than {MAX_BODY_BYTES} bytes.",
    415: "The body is not declared as JSON.",
    422: "Fields are invalid; `errors` names them.",
    429: "The limit of this hour or day is used up; retry after `Retry-After` seconds.",
    500: "Internal error.",
    503: "Storage or a function is temporarily unavailable; retry.",
}


@dataclass(frozen=True)
class Content:
    """Response body of one status: a model as JSON, pictures, or nothing."""

    description: str
    model: type[BaseModel] | None = None
    pictures: tuple[str, ...] = ()
    headers: tuple[str, ...] = ()  # of every such response
    sometimes: tuple[str, ...] = ()  # of some responses
    media_type: str = JSON
    other: type[BaseModel] | None = None  # model that it may be instead


@dataclass(frozen=True)
class Operation:
    """One call of the API."""

    method: Literal["get", "post", "patch", "delete"]
    path: str
    name: str
    summary: str
    answers: dict[int, Content]
    credentials: tuple[str, ...] = ()
    body: type[BaseModel] | None = None
    parameters: tuple[Node, ...] = ()
    problems: tuple[int, ...] = ()  # besides those of every call, of a credential and of a body
    body_required: bool = True
    example: Any = None  # body of a request
    example_query: Mapping[str, str] = field(default_factory=dict)
    example_path: Mapping[str, str] = field(default_factory=dict)
    example_accept: str | None = None

    @property
    def tag(self) -> str:
        """Name of the group, one of `TAGS`."""
        return next((tag for start, tag in _GROUPS.items() if self.path.startswith(start)), "Database")

    @property
    def description(self) -> str:
        """Description of the call, in Markdown."""
        return texts("calls.md")[self.name]

    @property
    def signature(self) -> str:
        """Method and path."""
        return f"{self.method.upper()} {self.path}"

    @property
    def example_values(self) -> Mapping[str, str]:
        """Values of the example's parameters, without those of ids."""
        return {**self.example_query, **self.example_path}

    @property
    def example_address(self) -> str:
        """Path of the example, with placeholders of ids."""
        identity = "RIG_ID" if self.tag == "Rigs" else "CALIBRATION_ID"
        return self.path.format(**{"id": identity, "key": "CAMERA_KEY", **self.example_path})

    @property
    def example_credential(self) -> str | None:
        """Placeholder of the example's credential."""
        return next((CREDENTIALS[name] for name in self.credentials if name in CREDENTIALS), None)

    @property
    def all_problems(self) -> set[int]:
        """Statuses of all problems that the call can have."""
        problems = {500, 503, *self.problems}
        if self.credentials:
            problems |= {401, 403, 429}
        if self.body:
            problems |= {400, 413, 422}
        return problems - self.answers.keys()


def texts(name: str) -> dict[str, str]:
    """Return the paragraph under each heading of `web/templates/docs/NAME`, in Markdown."""
    _, *parts = re.split(r"^## (.+)$", (_TEXTS / name).read_text(encoding="utf-8"), flags=re.MULTILINE)
    paragraphs = (" ".join(part.split()) for part in parts[1::2])
    return dict(zip(parts[::2], paragraphs, strict=True))


SWITCH: Node = {"type": "string", "enum": ["0", "1", "false", "true"]}
_SIZE_PARAMETER: Node = {"type": "string", "pattern": "^[0-9]+x[0-9]+$", "examples": ["1280x720"]}
_DEPRECATED = "Spelling of the older public client."
_KEYWORDS = (
    *("type", "enum", "pattern", "minLength", "maxLength", "minimum", "maximum", "default", "examples"),
)


def query(name: str, content: Node, description: str) -> Node:
    """Make an optional query parameter by hand."""
    return {"name": name, "in": "query", "schema": content, "description": description}


def path(
    name: str, description: str, content: Mapping[str, Any] = MappingProxyType({"type": "string"})
) -> Node:
    """Make a path parameter by hand."""
    return {"name": name, "in": "path", "required": True, "schema": dict(content), "description": description}


def query_of(
    model: type[BaseModel],
    descriptions: Mapping[str, str] | None = None,
    deprecated: Collection[str] = (),
    body_only: Collection[str] = (),
) -> tuple[Node, ...]:
    """Generate the query parameters of a model.

    `descriptions` replace those of its fields. `deprecated`: aliases that are listed as deprecated
    parameters; others are not listed. `body_only`: fields that a query cannot write.
    """
    nodes = model.model_json_schema(by_alias=False)["properties"]
    parameters = []
    for name, info in model.model_fields.items():
        if name in body_only:
            continue
        choices = info.validation_alias
        known = choices.choices if isinstance(choices, AliasChoices) else ()
        aliases = [str(alias) for alias in known if alias in deprecated]
        node = query(name, _as_text(nodes[name]), (descriptions or {}).get(name) or info.description or "")
        parameters.append(node | ({"required": True} if info.is_required() and not aliases else {}))
        parameters += [query(alias, node["schema"], _DEPRECATED) | {"deprecated": True} for alias in aliases]
    return tuple(parameters)


def _as_text(node: Node) -> Node:
    """Convert a field's JSON schema to that of its text in a query.

    Two numbers are a size, as in 1280x720; commas separate the numbers of other lists.
    """
    merged = next((choice for choice in node.get("anyOf", ()) if choice.get("type") != "null"), {}) | node
    if merged["type"] == "boolean":
        return SWITCH
    if merged["type"] == "array":
        count = len(merged.get("prefixItems", ()))
        if count == 2:
            return _SIZE_PARAMETER
        number = "[0-9]+"
        pattern = ",".join([number] * count) if count else f"{number}(,{number})*"
        return {"type": "string", "pattern": f"^{pattern}$", "examples": merged["examples"]}
    default = merged.get("default")
    if isinstance(default, float) and default.is_integer():
        merged["default"] = int(default)
    return {key: merged[key] for key in _KEYWORDS if merged.get(key) is not None}
