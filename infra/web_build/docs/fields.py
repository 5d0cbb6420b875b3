"""Fields of JSON schemas as rows of a table."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from infra.web_build import openapi
from infra.web_build.operation import JSON, Node

_SCHEMA_PREFIX = "#/components/schemas/"
_MAX_MEMBER_DEPTH = 3  # of members within members
_NAMES = {"string": "text", "integer": "whole number", "number": "number", "boolean": "true or false"}
_BOUNDS = (
    ("minimum", "maximum", "{}"),
    ("exclusiveMinimum", "exclusiveMaximum", "{} (not included)"),
    ("minLength", "maxLength", "{} characters"),
)
_MAX_WITHOUT_COMMAS = 9999


@dataclass(frozen=True)
class Row:
    """One field: its path from the body's root, its values, and its meaning."""

    name: str
    kind: str
    required: bool
    text: str


def rows(schema: Node, prefix: str = "", depth: int = 0) -> Iterator[Row]:
    """Yield the fields of an object, each followed by its members."""
    whole = _resolve(schema)
    needed = set(whole.get("required", ()))
    for name, node in whole.get("properties", {}).items():
        text = node.get("description") or _resolve(node).get("description", "")
        yield Row(f"{prefix}{name}", kind(node), name in needed, text)
        inner, mark = _object(node)
        if inner is not None and depth < _MAX_MEMBER_DEPTH:
            yield from rows(inner, f"{prefix}{name}{mark}.", depth + 1)


def parameter_rows(operation: Node) -> list[Row]:
    """Return the parameters of an operation, without deprecated ones."""
    return [
        Row(each["name"], kind(each["schema"]), each.get("required", False), each["description"])
        for each in operation.get("parameters", ())
        if not each.get("deprecated")
    ]


def body_rows(operation: Node) -> list[Row]:
    """Return the fields of an operation's request."""
    content = operation.get("requestBody", {}).get("content", {})
    return list(rows(content[JSON]["schema"])) if content else []


def _resolve(node: Node) -> Node:
    """Follow a reference, and the one choice of several that is not null."""
    while True:
        reference = node.get("$ref", "")
        if reference.startswith(_SCHEMA_PREFIX):
            node = openapi.document()["components"]["schemas"][reference.removeprefix(_SCHEMA_PREFIX)]
            continue
        choices = [choice for choice in node.get("anyOf", ()) if choice.get("type") != "null"]
        if len(choices) != 1:
            return node
        node = choices[0]


def _object(node: Node) -> tuple[Node | None, str]:
    """Find the object that a field is, or that its items are, and the mark of its path."""
    whole = _resolve(node)
    if "properties" in whole:
        return whole, ""
    items = _resolve(whole.get("items") or {})
    return (items, "[]") if "properties" in items else (None, "")


def kind(node: Node) -> str:
    """Describe the values of a field."""
    null = any(choice.get("type") == "null" for choice in node.get("anyOf", ()))
    default = node.get("default")
    whole = _resolve(node)
    choices = [choice for choice in whole.get("anyOf", ()) if choice.get("type") != "null"]
    said = " or ".join(dict.fromkeys(kind(choice) for choice in choices)) or _single(whole)
    if null:
        said += ", or null"
    if default is not None and not isinstance(default, dict | list):
        said += f"; {_format_value(default)} unless given"
    return said


def _single(node: Node) -> str:
    if "const" in node:
        return _format_value(node["const"])
    if "enum" in node:
        return "one of " + ", ".join(_format_value(value) for value in node["enum"])
    if node.get("type") == "array":
        return _list(node)
    if node.get("type") == "object" or "properties" in node:
        return "object"
    bounds = [words.format(_range(node[low], node.get(high))) for low, high, words in _BOUNDS if low in node]
    bounds += [
        words.format(f"at most {_number(node[high])}")
        for low, high, words in _BOUNDS
        if high in node and low not in node
    ]
    return ", ".join([_NAMES.get(node.get("type", ""), "anything"), *bounds])


def _range(least: float, most: float | None) -> str:
    return f"at least {_number(least)}" if most is None else f"{_number(least)} to {_number(most)}"


def _number(value: float) -> str:
    whole = int(value) if float(value).is_integer() else value
    return f"{whole:,}" if abs(whole) > _MAX_WITHOUT_COMMAS else str(whole)


def _list(node: Node) -> str:
    fixed = node.get("prefixItems")
    if fixed:
        return f"list of {len(fixed)}: {kind(fixed[0])}"
    items = kind(node.get("items") or {})
    least, most = node.get("minItems"), node.get("maxItems")
    if least and least == most:
        return f"list of {least}: {items}"
    bounds = _range(least or 0, most) + " of them" if least or most is not None else ""
    return f"list, {bounds}: {items}" if bounds else f"list: {items}"


def _format_value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return _number(value) if isinstance(value, int | float) else str(value)
