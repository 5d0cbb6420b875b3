"""Builds `web/openapi.json` from the models that the functions check requests with: `make openapi`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel
from pydantic.json_schema import JsonSchemaMode, models_json_schema

from calibdb import __version__, schema
from calibdb.http import MAX_BODY
from calibdb.schema.fields import MAX_INDEX

TARGET = Path(__file__).resolve().parents[2] / "web" / "openapi.json"
_REFERENCE = "#/components/schemas/{model}"

JSON, PROBLEM, JPEG, PNG = "application/json", "application/problem+json", "image/jpeg", "image/png"
Node = dict[str, Any]

_PROBLEMS = {
    400: "The body is not JSON.",
    401: "No credential was sent.",
    403: "The credential is unknown, expired, or not for this origin.",
    404: "There is no such thing.",
    406: "None of the accepted media types can be given.",
    409: "The request does not fit the state that things are in.",
    413: f"The body is larger than {MAX_BODY} bytes.",
    422: "Fields are not what they must be; `errors` names them.",
    429: "The plan's calls of this hour are used up; `Retry-After` says when the next begins.",
    500: "Something went wrong here, not in the request.",
    503: "Storage or another function did not answer; try again.",
}


@dataclass(frozen=True)
class Content:
    """What one status answers: a model as JSON, pictures, or nothing."""

    description: str
    model: type[BaseModel] | None = None
    pictures: tuple[str, ...] = ()
    headers: tuple[str, ...] = ()
    media_type: str = JSON


@dataclass(frozen=True)
class Operation:
    """One call of the API."""

    method: Literal["get", "post", "delete"]
    path: str
    name: str
    summary: str
    answers: dict[int, Content]
    problems: tuple[int, ...] = ()
    credentials: tuple[str, ...] = ()
    body: type[BaseModel] | None = None
    parameters: tuple[Node, ...] = ()


def _query(name: str, content: Node, description: str, *, required: bool = False, old: bool = False) -> Node:
    node = {"name": name, "in": "query", "schema": content, "description": description}
    return node | ({"required": True} if required else {}) | ({"deprecated": True} if old else {})


def _path(name: str, content: Node, description: str) -> Node:
    return {"name": name, "in": "path", "required": True, "schema": content, "description": description}


_TEXT: Node = {"type": "string", "minLength": 1, "maxLength": 256}
_SIZE: Node = {"type": "string", "pattern": "^[0-9]+x[0-9]+$", "examples": ["1280x720"]}
_SWITCH: Node = {"type": "string", "enum": ["0", "1", "false", "true"]}
_REDIRECT = _query("redirect", _SWITCH, "`false`: 404 with `guidance_url` instead of the redirect.")
_OLD = "Spelling of the older public client."
_KEY = (
    _query("camera", _TEXT, "`MediaStreamTrack.label`", required=True),
    # Required, too, but by one of two names.
    _query("platform", _TEXT, "The parenthesised part of the user agent."),
    _query("userAgent", _TEXT, _OLD, old=True),
    _query("img_size", _SIZE, "Width and height, px."),
    _query("imsize", _SIZE, _OLD, old=True),
    _query("zoom", {"type": "number", "minimum": 0, "maximum": 1e6, "default": 0}, "`zoom` of the track."),
    _query(
        "distortion_model",
        {"type": "string", "enum": list(schema.DISTORTION_MODELS), "default": "rectilinear"},
        "The model to answer with.",
    ),
)
_STATE = Content("The session's state.", schema.SessionState)
_TOKEN, _SESSION = ("apiToken",), ("sessionId",)
_ASKED = (401, 403, 429, 500, 503)
_FOUND = {
    200: Content("The calibration.", schema.Calibration),
    307: Content("Nothing reliable is known: to the guidance page.", schema.Miss, headers=("Location",)),
    404: Content(
        "Nothing reliable is known, and `redirect=false`.", schema.LookupProblem, media_type=PROBLEM
    ),
}

OPERATIONS = (
    Operation(
        "post",
        "/v1/auth",
        "openSession",
        "Exchange an API token for the credential of one guided capture",
        {201: Content("A session id, signed and short-lived.", schema.SessionOpened)},
        _ASKED,
        _TOKEN,
    ),
    Operation(
        "post",
        "/v1/session",
        "startSession",
        "Start a guided capture; the same content again is answered again",
        {201: _STATE},
        (400, *_ASKED, 409, 413, 422),
        _SESSION,
        schema.SessionRequest,
    ),
    Operation(
        "get", "/v1/session", "showSession", "How far it has come", {200: _STATE}, (*_ASKED, 404), _SESSION
    ),
    Operation(
        "delete",
        "/v1/session",
        "forgetSession",
        "Forget the session's views",
        {204: Content("Forgotten.")},
        (*_ASKED, 404, 409),
        _SESSION,
    ),
    Operation(
        "get",
        "/v1/session/pose",
        "showPose",
        "Where to hold the board next; the same pose until a view answers it",
        {
            200: Content(
                "The board as the camera would see it there, black elsewhere; or the same in numbers.",
                schema.Pose,
                (JPEG, PNG),
            )
        },
        (*_ASKED, 404, 406, 409, 422),
        _SESSION,
        parameters=(_query("skip", _SWITCH, "`1`: a pose of another kind instead of the open one."),),
    ),
    Operation(
        "post",
        "/v1/session/views",
        "submitView",
        "Submit the corners seen; a refused view changes nothing and its index stays open",
        {200: Content("The session's state, and whether the view is part of it.", schema.ViewAnswer)},
        (400, *_ASKED, 404, 409, 413, 422),
        _SESSION,
        schema.ViewRequest,
    ),
    Operation(
        "delete",
        "/v1/session/views/{index}",
        "undoView",
        "Undo a view",
        {200: _STATE},
        (*_ASKED, 404, 409, 422),
        _SESSION,
        parameters=(
            _path("index", {"type": "integer", "minimum": 0, "maximum": MAX_INDEX}, "Index of the view."),
        ),
    ),
    Operation(
        "post",
        "/v1/lookup",
        "lookup",
        "The calibration of a camera",
        _FOUND,
        (400, *_ASKED, 413, 422),
        _TOKEN,
        schema.LookupRequest,
        (_REDIRECT,),
    ),
    Operation(
        "get",
        "/v1/lookup",
        "visitLookup",
        "The calibration of a camera, or a navigation to the guidance page",
        _FOUND,
        (*_ASKED, 422),
        ("apiToken", "apiTokenInQuery", "apiTokenInOldQuery"),
        parameters=(*_KEY, _REDIRECT),
    ),
    Operation(
        "get",
        "/v1/calibrations/{id}",
        "showCalibration",
        "One stored calibration or consensus",
        {200: Content("The calibration.", schema.Calibration)},
        (*_ASKED, 404, 422),
        _TOKEN,
        parameters=(
            _path("id", {"type": "string"}, "As a session or a lookup answered it."),
            _query("format", {"type": "string", "enum": ["calibdb"], "default": "calibdb"}, "File format."),
        ),
    ),
    Operation(
        "post",
        "/v1/checks",
        "checkCalibration",
        "Whether the stored consensus, reliable or not, fits fresh views of this camera",
        {200: Content("Whether it fits, and what checks say of it by now.", schema.CheckAnswer)},
        (400, *_ASKED, 404, 413, 422),
        _SESSION,
        schema.CheckRequest,
    ),
    Operation(
        "get",
        "/healthz",
        "health",
        "Whether the service is there",
        {200: Content("It is.", schema.Health)},
        (500,),
    ),
)


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
        if content.headers:
            node["headers"] = {
                name: {"schema": {"type": "string"}, "required": True} for name in content.headers
            }
        return node

    problem = {PROBLEM: {"schema": reference(schema.Problem, "serialization")}}
    responses = {status: answer(content) for status, content in operation.answers.items()}
    responses |= {
        status: {"description": _PROBLEMS[status], "content": problem} for status in operation.problems
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
    TARGET.write_text(text())
