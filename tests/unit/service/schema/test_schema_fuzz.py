"""Every schema under what its own JSON Schema allows, and under anything: a model, or a ValidationError."""

import importlib
import json
import os
import pkgutil
import re
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, ValidationError
from pydantic.json_schema import models_json_schema

from calibdb import schema

EXAMPLES = int(os.environ.get("CASES", "160")) // 20
FUZZ = settings(
    max_examples=EXAMPLES,
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=list(HealthCheck),
)
MODELS = sorted(
    {
        model
        for module in pkgutil.iter_modules(schema.__path__, "calibdb.schema.")
        for model in vars(importlib.import_module(module.name)).values()
        if isinstance(model, type) and issubclass(model, BaseModel) and model.__module__.startswith("calibdb")
    },
    key=lambda model: model.__name__,
)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=10,
)
_LARGE = 1e9


def with_parts_thorough() -> list[Any]:
    """Every model; parts of another, which are read with it, marked thorough."""
    defined = models_json_schema([(model, "validation") for model in MODELS])[1]["$defs"]
    parts = set(re.findall(r'"#/\$defs/(\w+)"', json.dumps(defined)))
    return [
        pytest.param(model, id=name, marks=pytest.mark.thorough if name in parts else ())
        for model in MODELS
        for name in [model.__name__]
    ]


READ = with_parts_thorough()


def described(node: dict[str, Any], known: dict[str, Any], depth: int = 0) -> st.SearchStrategy[Any]:
    """Values of a JSON Schema as pydantic writes it; now and then one that is not."""
    if "$ref" in node:
        return described(known[node["$ref"].rpartition("/")[2]], known, depth)
    if "anyOf" in node:
        return st.one_of([described(option, known, depth) for option in node["anyOf"]])
    if "enum" in node:
        return st.sampled_from(node["enum"])
    if "const" in node:
        return st.just(node["const"])
    match node.get("type"):
        case "object":
            return members(node, known, depth)
        case "array":
            return elements(node, known, depth)
        case "string" if "pattern" in node:
            return st.from_regex(node["pattern"], fullmatch=True) | st.text(max_size=40)
        case "string":
            return st.text(min_size=node.get("minLength", 0), max_size=min(node.get("maxLength", 40), 40))
        case "integer":
            return st.integers(*(round(bound) for bound in bounds(node)))
        case "number":
            low, high = bounds(node)
            return st.floats(low, high, exclude_min="exclusiveMinimum" in node)
        case "boolean":
            return st.booleans()
        case "null":
            return st.none()
    return JSON


def bounds(node: dict[str, Any]) -> tuple[float, float]:
    low = node.get("minimum", node.get("exclusiveMinimum", -_LARGE))
    high = node.get("maximum", node.get("exclusiveMaximum", _LARGE))
    return low, high


def members(node: dict[str, Any], known: dict[str, Any], depth: int) -> st.SearchStrategy[Any]:
    if depth > 5:
        return st.just({})
    inner = {name: described(of, known, depth + 1) for name, of in node.get("properties", {}).items()}
    required = set(node.get("required", ()))
    more = node.get("additionalProperties")
    if not inner and isinstance(more, dict):
        names = described(node.get("propertyNames", {"type": "string"}), known)
        return st.dictionaries(names, described(more, known, depth + 1), max_size=3)
    return st.fixed_dictionaries(
        {name: of for name, of in inner.items() if name in required},
        optional={name: of for name, of in inner.items() if name not in required},
    )


def elements(node: dict[str, Any], known: dict[str, Any], depth: int) -> st.SearchStrategy[Any]:
    if "prefixItems" in node:
        return st.tuples(*(described(item, known, depth + 1) for item in node["prefixItems"])).map(list)
    least = node.get("minItems", 0)
    return st.lists(
        described(node.get("items", {}), known, depth + 1),
        min_size=least,
        max_size=min(node.get("maxItems", least + 3), least + 3),
    )


def holds(model: type[BaseModel], content: str | bytes) -> bool:
    """Read `content`; if it is accepted, check that it is written and read again unchanged."""
    try:
        found = model.model_validate_json(content)
    except ValidationError:
        return False
    written = found.model_dump_json(by_alias=True)
    json.dumps(json.loads(written), allow_nan=False)
    assert model.model_validate_json(written) == found
    return True


@pytest.mark.parametrize("model", READ)
def test_described_documents_are_accepted(model: type[BaseModel]) -> None:
    node = model.model_json_schema()
    accepted = []

    @FUZZ
    @given(described(node, node.get("$defs", {})))
    def read(value: Any) -> None:
        accepted.append(holds(model, json.dumps(value)))

    read()
    assert any(accepted), "nothing that the schema describes is accepted"


@pytest.mark.parametrize("model", READ)
def test_arbitrary_documents_are_read_or_refused(model: type[BaseModel]) -> None:
    names = list(model.model_fields)

    @FUZZ
    @given(
        JSON.map(json.dumps).map(str.encode)
        | st.dictionaries(st.sampled_from(names) if names else st.text(), JSON, max_size=6).map(
            lambda value: json.dumps(value).encode()
        )
        | st.binary(max_size=40)
    )
    def read(content: bytes) -> None:
        holds(model, content)

    read()


def test_stored_members_hold_finite_numbers() -> None:
    content = """{"camera_key": "a", "camera": "a", "platform": "b", "img_size": [16, 16], "zoom": 0,
        "distortion_model": "rectilinear", "board": {}, "guidance": "projection-uncertainty",
        "track": {}, "started": 0, "target_error": 1, "session": "s",
        "target": {"x": Infinity, "y": [1, NaN, {"z": -Infinity}]}}"""
    document = schema.documents.SessionDocument.model_validate_json(content)
    assert document.target == {"x": None, "y": [1, None, {"z": None}]}
