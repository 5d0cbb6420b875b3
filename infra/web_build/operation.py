"""One call of the API: its contents, and the problems that calls answer with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pydantic import BaseModel

from calibdb.http.call import MAX_BODY_BYTES
from infra.web_build.parameters import Node

JSON, PROBLEM, JPEG, PNG = "application/json", "application/problem+json", "image/jpeg", "image/png"
SVG = "image/svg+xml"

PROBLEMS = {
    400: "The body is not JSON.",
    401: "No credential was sent.",
    403: "The credential is unknown, expired, or not for this origin.",
    404: "There is no such thing.",
    406: "None of the accepted media types can be given.",
    409: "The request does not fit the state that things are in.",
    410: "It was withdrawn; `reason` says for what kind of reason: wrong, abuse, privacy, other.",
    413: f"The body is larger than {MAX_BODY_BYTES} bytes.",
    415: "The body is not declared as JSON.",
    422: "Fields are not what they must be; `errors` names them.",
    429: "The calls that are allowed in this hour or day are used up; `Retry-After` says when more are.",
    500: "Something went wrong here, not in the request.",
    503: "Storage or another function did not answer; try again.",
}


@dataclass(frozen=True)
class Content:
    """Response body of one status: a model as JSON, pictures, or nothing."""

    description: str
    model: type[BaseModel] | None = None
    pictures: tuple[str, ...] = ()
    headers: tuple[str, ...] = ()  # that every such answer carries
    sometimes: tuple[str, ...] = ()  # that some carry
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
    problems: tuple[int, ...] = ()
    credentials: tuple[str, ...] = ()
    body: type[BaseModel] | None = None
    parameters: tuple[Node, ...] = ()
    body_required: bool = True
