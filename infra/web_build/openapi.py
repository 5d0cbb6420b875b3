"""Builds `web/openapi.json` from the models that the functions check requests with: `make openapi`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import JsonSchemaMode, models_json_schema

from calibdb import __version__, schema
from infra.web_build.operations import JSON, OPERATIONS, PROBLEM, PROBLEMS, Content, Operation
from infra.web_build.parameters import Node

__all__ = ["OPENAPI_PATH", "OPERATIONS", "document", "text"]

OPENAPI_PATH = Path(__file__).resolve().parents[2] / "web" / "openapi.json"
_REFERENCE = "#/components/schemas/{model}"


def document() -> Node:
    """Return the OpenAPI 3.1 document."""
    requests, answers = _models(OPERATIONS)
    wanted: list[tuple[type[BaseModel], JsonSchemaMode]] = [
        *((model, "validation") for model in requests),
        *((model, "serialization") for model in answers),
    ]
    names, definitions = models_json_schema(wanted, ref_template=_REFERENCE)
    paths: dict[str, Node] = {}
    for operation in OPERATIONS:
        paths.setdefault(operation.path, {})[operation.method] = _operation(operation, names)
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "calibDB",
            "version": __version__,
            "summary": "Camera calibrations for the web",
            "license": {"name": "Apache-2.0", "identifier": "Apache-2.0"},
        },
        "servers": [{"url": "/"}],
        "paths": paths,
        "components": {
            "schemas": definitions["$defs"],
            "securitySchemes": {
                "apiToken": {"type": "http", "scheme": "bearer", "bearerFormat": "cdb_<id>_<secret>"},
                "apiTokenInQuery": {"type": "apiKey", "in": "query", "name": "key"},
                "apiTokenInOldQuery": {"type": "apiKey", "in": "query", "name": "api_key"},
                "sessionId": {"type": "http", "scheme": "bearer", "bearerFormat": "signed session id"},
            },
        },
    }


def _models(operations: Sequence[Operation]) -> tuple[list[type[BaseModel]], list[type[BaseModel]]]:
    requests = {o.body: None for o in operations if o.body}
    answers = {c.model: None for o in operations for c in o.answers.values() if c.model}
    return list(requests), [*answers, schema.Problem]


def _operation(operation: Operation, names: Any) -> Node:
    def reference(model: type[BaseModel], mode: JsonSchemaMode) -> Node:
        found: Node = names[(model, mode)]
        return found

    def answer(content: Content) -> Node:
        node: Node = {"description": content.description}
        if content.model or content.pictures:
            media: Node = {picture: {} for picture in content.pictures}
            if content.model:
                media[content.media_type] = {"schema": reference(content.model, "serialization")}
            node["content"] = media
        always = {name: {"schema": {"type": "string"}, "required": True} for name in content.headers}
        some = {name: {"schema": {"type": "string"}} for name in content.sometimes}
        if always or some:
            node["headers"] = always | some
        return node

    problem = {PROBLEM: {"schema": reference(schema.Problem, "serialization")}}
    responses = {status: answer(content) for status, content in operation.answers.items()}
    responses |= {
        status: {"description": PROBLEMS[status], "content": problem} for status in operation.problems
    }
    node: Node = {
        "operationId": operation.name,
        "summary": operation.summary,
        "responses": {str(status): responses[status] for status in sorted(responses)},
    }
    if operation.parameters:
        node["parameters"] = list(operation.parameters)
    if operation.body:
        content = {JSON: {"schema": reference(operation.body, "validation")}}
        node["requestBody"] = {"required": True, "content": content}
    if operation.credentials:
        node["security"] = [{name: []} for name in operation.credentials]
    return node


def text() -> str:
    """Return the file's content."""
    return json.dumps(document(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    OPENAPI_PATH.write_text(text())
