"""OpenAPI document and JSON Schemas of the site, built from the models that functions check requests with.

python -m infra.web_build.openapi .build/openapi.json     # the document as a file
"""

import functools
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import JsonSchemaMode, models_json_schema

from calibdb import __version__, schema
from calibdb.schema.dump import Dump, Statistics
from infra.web_build.operation import JSON, PROBLEM, PROBLEMS, TAGS, Content, Node, Operation
from infra.web_build.operations import OPERATIONS

__all__ = ["OPENAPI_KEY", "OPERATIONS", "document", "text"]

EXAMPLES_PATH = Path(__file__).resolve().parents[2] / ".build" / "examples.json"
"""Answers to the examples of `operations`, written by `infra.web_build.recorded_examples`."""
OPENAPI_KEY = "openapi.json"
CALIBRATION_VERSION = 1
"""Another one removes a member, or gives it another meaning; new members do not change it."""
CALIBRATION_SCHEMA_KEY = f"docs/schema/calibration-{CALIBRATION_VERSION}.json"
DUMP_SCHEMA_KEY = "data/schema.json"
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
    limited = RATE_LIMITED if set(operation.credentials) & {"apiToken", "sessionId"} else ()

    def answer(content: Content) -> Node:
        node: Node = {"description": content.description}
        if content.model or content.pictures:
            media: Node = {picture: {} for picture in content.pictures}
            if content.model:
                shown = [names[one, "serialization"] for one in (content.model, content.other) if one]
                media[content.media_type] = {"schema": {"anyOf": shown} if len(shown) > 1 else shown[0]}
            node["content"] = media
        always = {name: {"schema": {"type": "string"}, "required": True} for name in content.headers}
        some = {name: {"schema": {"type": "string"}} for name in (*content.sometimes, *limited)}
        if always or some:
            node["headers"] = always | some
        return node

    problem = {PROBLEM: {"schema": names[schema.Problem, "serialization"]}}
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
        content = {JSON: {"schema": names[operation.body, "validation"], "example": operation.example}}
        node["requestBody"] = {"required": operation.body_required, "content": content}
    if operation.credentials:
        node["security"] = [{name: []} for name in operation.credentials]
    return node


def node(operation: Operation) -> Node:
    """Return the description of a call in the document."""
    described: Node = document()["paths"][operation.path][operation.method]
    return described


def text() -> str:
    """Return the file's content."""
    return json.dumps(document(), indent=1, ensure_ascii=False) + "\n"


def files() -> dict[str, str]:
    """Return the content of each file of the site, by its key."""
    return {OPENAPI_KEY: text(), CALIBRATION_SCHEMA_KEY: calibration_schema(), DUMP_SCHEMA_KEY: dump_schema()}


def calibration_schema() -> str:
    """Return the schema of a calibration document."""
    models = (schema.LookupAnswer, schema.ReportedCalibration, schema.GivenCalibration)
    definitions = _definitions(models, "validation")
    lookup, reported, stored = (definitions.pop(model.__name__) for model in models)
    return _schema_text(
        {
            "$id": f"/{CALIBRATION_SCHEMA_KEY}",
            "title": f"Calibration of calibDB, version {CALIBRATION_VERSION}",
            "description": "As a lookup, GET /v1/calibrations/{id} and the export format calibdb return it, "
            "and as the Python client saves it. Only what makes a camera is required.",
            "type": "object",
            "properties": lookup["properties"] | reported["properties"],
            "required": stored["required"],
            "$defs": definitions,
        }
    )


def dump_schema() -> str:
    """Return the schema of a dump."""
    return _schema_text(
        {
            "title": "Dump of calibDB, version 1",
            "description": "Of /dumps/latest.json. $defs also has Statistics, of /dumps/statistics.json, and "
            "the documents in the files, one a line: CalibrationDocument and VoteDocument.",
            "$ref": "#/$defs/Dump",
            "$defs": _definitions(
                (Dump, Statistics, schema.CalibrationDocument, schema.VoteDocument), "serialization"
            ),
        }
    )


def _definitions(models: tuple[type[BaseModel], ...], mode: JsonSchemaMode) -> dict[str, Any]:
    _, made = models_json_schema([(model, mode) for model in models], ref_template="#/$defs/{model}")
    definitions: dict[str, Any] = made["$defs"]
    return definitions


def _schema_text(members: Mapping[str, Any]) -> str:
    content = {"$schema": "https://json-schema.org/draft/2020-12/schema", **members}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(text(), encoding="utf-8")
