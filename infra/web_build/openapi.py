"""OpenAPI document, a file of the site, built from the models that functions check requests with.

python -m infra.web_build.openapi .build/openapi.json     # the document as a file
"""

from __future__ import annotations

import functools
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import JsonSchemaMode, models_json_schema

from calibdb import __version__, schema
from infra.web_build.operation import JSON, PROBLEM, PROBLEMS, TAGS, Content, Operation
from infra.web_build.operations import OPERATIONS
from infra.web_build.parameters import Node

__all__ = ["OPENAPI_KEY", "OPERATIONS", "document", "text"]

EXAMPLES_PATH = Path(__file__).resolve().parents[2] / ".build" / "examples.json"
"""Answers to the examples of `operations`, written by `infra.web_build.recorded_examples`."""
OPENAPI_KEY = "openapi.json"
RATE_LIMITED = ("RateLimit-Policy", "RateLimit")
"""Headers of every response under a plan with limits."""
_REFERENCE = "#/components/schemas/{model}"


@functools.cache
def document() -> Node:
    """Return the OpenAPI 3.1 document; callers may not change it."""
    requests, answers = _models(OPERATIONS)
    models_and_modes: list[tuple[type[BaseModel], JsonSchemaMode]] = [
        *((model, "validation") for model in requests),
        *((model, "serialization") for model in answers),
    ]
    names, definitions = models_json_schema(models_and_modes, ref_template=_REFERENCE)
    examples = json.loads(EXAMPLES_PATH.read_text(encoding="utf-8"))
    paths: dict[str, Node] = {}
    for operation in OPERATIONS:
        node = _operation(operation, names, examples.get(operation.name))
        paths.setdefault(operation.path, {})[operation.method] = node
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "calibDB",
            "version": __version__,
            "summary": "Camera calibrations for the web",
            "license": {"name": "Apache-2.0", "identifier": "Apache-2.0"},
        },
        "servers": [{"url": "/"}],
        "tags": [{"name": name, "description": description} for name, description in TAGS.items()],
        "paths": paths,
        "components": {
            "schemas": definitions["$defs"],
            "securitySchemes": {
                "apiToken": {"type": "http", "scheme": "bearer", "bearerFormat": "cdb_<id>_<secret>"},
                "apiTokenInQuery": {"type": "apiKey", "in": "query", "name": "key"},
                "apiTokenInOldQuery": {"type": "apiKey", "in": "query", "name": "api_key"},
                "managementToken": {"type": "http", "scheme": "bearer", "bearerFormat": "cdbm_<id>_<secret>"},
                "sessionId": {"type": "http", "scheme": "bearer", "bearerFormat": "signed session id"},
            },
        },
    }


def _models(operations: Sequence[Operation]) -> tuple[list[type[BaseModel]], list[type[BaseModel]]]:
    requests = {o.body: None for o in operations if o.body}
    contents = [c for o in operations for c in o.answers.values()]
    answers = {model: None for c in contents for model in (c.model, c.other) if model}
    return list(requests), [*answers, schema.Problem]


def _operation(operation: Operation, names: Any, example: Any) -> Node:
    def reference(model: type[BaseModel], mode: JsonSchemaMode) -> Node:
        node: Node = names[(model, mode)]
        return node

    limited = RATE_LIMITED if set(operation.credentials) & {"apiToken", "sessionId"} else ()

    def answer(content: Content) -> Node:
        node: Node = {"description": content.description}
        if content.model or content.pictures:
            media: Node = {picture: {} for picture in content.pictures}
            if content.model:
                shown = [reference(one, "serialization") for one in (content.model, content.other) if one]
                media[content.media_type] = {"schema": {"anyOf": shown} if len(shown) > 1 else shown[0]}
            node["content"] = media
        always = {name: {"schema": {"type": "string"}, "required": True} for name in content.headers}
        some = {name: {"schema": {"type": "string"}} for name in (*content.sometimes, *limited)}
        if always or some:
            node["headers"] = always | some
        return node

    problem = {PROBLEM: {"schema": reference(schema.Problem, "serialization")}}
    responses = {status: answer(content) for status, content in operation.answers.items()}
    responses |= {
        status: {"description": PROBLEMS[status], "content": problem} for status in operation.all_problems
    }
    shown = responses[min(operation.answers)].get("content", {}).get(JSON)
    if example is not None and shown is not None:
        shown["example"] = example
    node: Node = {
        "operationId": operation.name,
        "tags": [operation.tag],
        "summary": operation.summary,
        "description": operation.description,
        "responses": {str(status): responses[status] for status in sorted(responses)},
    }
    if operation.parameters:
        node["parameters"] = list(operation.parameters)
    if operation.body:
        content = {JSON: {"schema": reference(operation.body, "validation"), "example": operation.example}}
        node["requestBody"] = {"required": operation.body_required, "content": content}
    if operation.credentials:
        node["security"] = [{name: []} for name in operation.credentials]
    return node


def text() -> str:
    """Return the file's content."""
    return json.dumps(document(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(text(), encoding="utf-8")
