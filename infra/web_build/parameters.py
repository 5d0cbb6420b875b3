"""OpenAPI parameters generated from the pydantic models that the functions parse queries with."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from pydantic import AliasChoices, BaseModel
from pydantic.fields import FieldInfo

Node = dict[str, Any]

SWITCH: Node = {"type": "string", "enum": ["0", "1", "false", "true"]}
_SIZE_PARAMETER: Node = {"type": "string", "pattern": "^[0-9]+x[0-9]+$", "examples": ["1280x720"]}
_DEPRECATED = "Spelling of the older public client."
_KEYWORDS = (
    *("type", "enum", "pattern", "minLength", "maxLength", "minimum", "maximum", "default", "examples"),
)


def query(name: str, content: Node, description: str) -> Node:
    """Make an optional query parameter by hand."""
    return {"name": name, "in": "query", "schema": content, "description": description}


def path(name: str, content: Node, description: str) -> Node:
    """Make a path parameter by hand."""
    return {"name": name, "in": "path", "required": True, "schema": content, "description": description}


def query_of(
    model: type[BaseModel],
    descriptions: Mapping[str, str] | None = None,
    deprecated: Collection[str] = (),
    body_only: Collection[str] = (),
) -> tuple[Node, ...]:
    """Generate the query parameters of a model.

    Parameters
    ----------
    model
        Model of the query.
    descriptions
        Texts by field, over those of the model's fields.
    deprecated
        Aliases that are listed as deprecated parameters. Other aliases are not listed.
    body_only
        Fields that a query cannot write.
    """
    nodes = model.model_json_schema(by_alias=False)["properties"]
    parameters = []
    for name, info in model.model_fields.items():
        if name in body_only:
            continue
        aliases = [alias for alias in _aliases(info) if alias in deprecated]
        node = query(name, _as_text(nodes[name]), (descriptions or {}).get(name) or info.description or "")
        parameters.append(node | ({"required": True} if info.is_required() and not aliases else {}))
        parameters += [query(alias, node["schema"], _DEPRECATED) | {"deprecated": True} for alias in aliases]
    return tuple(parameters)


def _aliases(info: FieldInfo) -> list[str]:
    choices = info.validation_alias
    return [str(choice) for choice in choices.choices] if isinstance(choices, AliasChoices) else []


def _as_text(node: Node) -> Node:
    """Convert a field's JSON schema to that of its text in a query.

    A flag is 0, 1, false or true. Two numbers are a size, as in 1280x720; of other lists commas separate the
    numbers.
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
