"""HTTP, once for all functions: calls come in parsed, errors go out as problem+json.

A function is a few routes, each a plain function from `Call` to a Starlette response. One Lambda instance
serves one event at a time, so nothing here is gained by waiting asynchronously.
"""

from __future__ import annotations

import asyncio
import hmac
import json
import logging
import os
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any, TypeVar, cast

from mangum import Mangum
from pydantic import BaseModel, ValidationError
from pydantic_core import from_json
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from calibdb import metrics
from calibdb.accept import preferred
from calibdb.errors import (
    PROBLEMS,
    CalibdbError,
    FieldError,
    ForbiddenError,
    InvalidError,
    MalformedError,
    TooLargeError,
    UnauthenticatedError,
)
from calibdb.plans import Kind
from calibdb.schema.fields import MAX_INDEX
from calibdb.service import Service
from calibdb.tokens import ApiToken, Ticket

MAX_BODY = 1_000_000  # bytes; a view of the largest board with all digits is a tenth of it
_MOST_FIELDS = 20  # of a body with ten thousand wrong points the first few say enough

_HOPS_OF_EDGE = 2  # in X-Forwarded-For: the caller, CloudFront

_PROBLEM = "application/problem+json"
_TEXT = ["text/", "application/json", _PROBLEM]  # everything else leaves as base64

_log = logging.getLogger(__name__)
_HOST = ("host", "x-forwarded-port")
_FLAGS = {"1": True, "true": True, "0": False, "false": False}

Model = TypeVar("Model", bound=BaseModel)
LambdaHandler = Callable[[dict[str, Any], Any], dict[str, Any]]


@dataclass(frozen=True)
class Call:
    """One request, its body read, and the service that answers it."""

    request: Request
    body: bytes
    service: Service

    def json(self, model: type[Model]) -> Model:
        """Return the body as `model`.

        Raises TooLargeError, MalformedError, or InvalidError naming the fields.
        """
        if len(self.body) > MAX_BODY:
            raise TooLargeError(f"The body may have {MAX_BODY} bytes.")
        try:
            return model.model_validate_json(self.body)
        except ValidationError as error:
            raise _refusal(error) from error

    def query(self, model: type[Model]) -> Model:
        """Return the query as `model`; raises InvalidError naming every field."""
        try:
            return model.model_validate(dict(self.request.query_params))
        except ValidationError as error:
            raise _refusal(error) from error

    def json_text(self, name: str) -> str | None:
        """Return a text member of the body, None when there is none or the body is no JSON object."""
        if len(self.body) > MAX_BODY:
            raise TooLargeError(f"The body may have {MAX_BODY} bytes.")
        try:
            content = from_json(self.body)
        except ValueError:
            return None
        member = content.get(name) if isinstance(content, dict) else None
        return member if isinstance(member, str) else None

    def flag(self, name: str, *, default: bool = False) -> bool:
        """Return a query parameter that switches something: `1` or `true`, `0` or `false`."""
        text = self.request.query_params.get(name)
        if text is None:
            return default
        if text.lower() not in _FLAGS:
            raise InvalidError.field(name, "must be 0 or 1")
        return _FLAGS[text.lower()]

    def index(self, name: str) -> int:
        """Return a parameter of the path that is the index of a view."""
        text = self.path(name)
        if re.fullmatch(r"[0-9]{1,9}", text, re.ASCII) is None or int(text) > MAX_INDEX:
            raise InvalidError.field(name, f"must be a whole number from 0 to {MAX_INDEX}")
        return int(text)

    def accepted(self, types: Sequence[str]) -> str:
        """Return the media type, of those we have, that the caller likes best; NotAcceptableError if none."""
        return preferred(self.request.headers.get("accept") or "*/*", types)

    def session(self, charge: Kind | None = None) -> Ticket:
        """Return what the session id says, the call counted as one of `charge`.

        Raises UnauthenticatedError, ForbiddenError, or TooManyError.
        """
        ticket = self.service.session_ids.verify(self._bearer(), self.origin)
        token = self.service.token_of(ticket)
        if charge is not None:
            self.service.charge(token, charge, self.address)
        return ticket

    def api_token(self, credential: str | None = None, charge: Kind = "lookups") -> ApiToken:
        """Return the API token sent as bearer, or else `credential`, the call counted as one of `charge`.

        Raises UnauthenticatedError, ForbiddenError, or TooManyError.
        """
        if credential is not None and "authorization" not in self.request.headers:
            sent = credential
        else:
            sent = self._bearer()
        token = self.service.api_token(sent)
        if not token.admits(self.origin):
            raise ForbiddenError("The token is not for pages of this origin.", kind="origin")
        if charge == "lookups":
            self.service.count_lookup(token, self.address)
        else:
            self.service.charge(token, charge, self.address)
        return token

    @property
    def origin(self) -> str | None:
        """Origin of the page that asks, None outside a browser."""
        return self.request.headers.get("origin")

    @property
    def address(self) -> str:
        """Source address, only ever used inside a keyed hash.

        Of what came through our CloudFront the gateway sees CloudFront's. It is told apart by a secret, for
        anyone can write X-Forwarded-For; then the gateway appended the edge's address, the edge the caller's.
        """
        secret = self.service.settings.edge_secret
        shown = self.request.headers.get("x-calibdb-edge", "")
        if secret is not None and hmac.compare_digest(shown.encode(), secret.encode()):
            hops = self.request.headers.get("x-forwarded-for", "").split(",")
            if len(hops) >= _HOPS_OF_EDGE:
                return hops[-_HOPS_OF_EDGE].strip()
        return self.request.client.host if self.request.client else ""

    def path(self, name: str) -> str:
        """Return a parameter of the path."""
        return str(self.request.path_params[name])

    def _bearer(self) -> str:
        scheme, _, credential = self.request.headers.get("authorization", "").partition(" ")
        if scheme.lower() != "bearer" or not credential.strip():
            raise UnauthenticatedError("Send the credential as `Authorization: Bearer …`.")
        return credential.strip()


Endpoint = Callable[[Call], Response]


def answer(model: BaseModel, status: int = 200, headers: Mapping[str, str] | None = None) -> Response:
    """Return `model` as JSON."""
    return Response(model.model_dump_json(), status, headers, "application/json")


def nothing() -> Response:
    """Return the answer without a body."""
    return Response(status_code=204)


def resource(path: str, **methods: Endpoint) -> Route:
    """Return the route of one path: its methods in capitals, each with its endpoint; HEAD as GET."""

    async def endpoint(request: Request) -> Response:
        verb = "GET" if request.method == "HEAD" else request.method
        return methods[verb](Call(request, await request.body(), _service()))

    return Route(path, endpoint, methods=list(methods))


def application(*routes: Route) -> Starlette:
    """Return the application of `routes`: what it raises is answered as problem+json, without a trace."""
    return Starlette(
        routes=list(routes),
        exception_handlers={
            CalibdbError: _known,
            HTTPException: _starlette,
            Exception: _unknown,
        },
    )


def handler(*routes: Route) -> LambdaHandler:
    """Return what Lambda calls: payload format 2.0 in and out."""
    app = _without_caching(application(*routes))

    def handle(event: dict[str, Any], context: Any) -> dict[str, Any]:
        # Mangum asks for the thread's event loop. Lambda's thread has none, nor has a gateway's worker; one
        # of its own for each event is a tenth of a millisecond and leaves nothing behind.
        loop = asyncio.new_event_loop()
        asyncio.set_event_loop(loop)
        try:
            return Mangum(app, lifespan="off", text_mime_types=_TEXT)(_without_host(event), context)
        finally:
            asyncio.set_event_loop(None)
            loop.close()

    return handle


def _without_host(event: dict[str, Any]) -> dict[str, Any]:
    """Return the event without its host: nothing here depends on it, and Mangum fails on a malformed one."""
    headers = {k: v for k, v in event.get("headers", {}).items() if k.lower() not in _HOST}
    return {**event, "headers": headers}


def _service() -> Service:
    return Service.of(os.environ)


def _problem(error: CalibdbError) -> Response:
    return Response(
        json.dumps(error.problem(), ensure_ascii=False).encode(),
        error.status,
        error.headers,
        _PROBLEM,
    )


async def _known(_: Request, raised: Exception) -> Response:
    error = cast("CalibdbError", raised)
    if (
        error.status >= HTTPStatus.INTERNAL_SERVER_ERROR
    ):  # not the caller's doing, so the operator hears of it
        _log.error("%s", error.detail, exc_info=error)
        metrics.count(time.time(), reason=error.kind, Errors=1)
    return _problem(error)


async def _starlette(_: Request, raised: Exception) -> Response:
    error = cast("HTTPException", raised)
    title = HTTPStatus(error.status_code).phrase
    body = {
        "type": PROBLEMS + title.lower().replace(" ", "-"),
        "title": title,
        "status": error.status_code,
        "detail": "There is no such path." if error.status_code == HTTPStatus.NOT_FOUND else error.detail,
    }
    return Response(json.dumps(body), error.status_code, error.headers, _PROBLEM)


async def _unknown(_: Request, __: Exception) -> Response:
    # Starlette raises it again once this is sent, and Mangum logs it with its trace: for us, not for the
    # caller.
    metrics.count(time.time(), reason="internal", Errors=1)
    return _problem(CalibdbError("Something went wrong here, not in the request."))


def _refusal(error: ValidationError) -> CalibdbError:
    problems = error.errors(include_url=False, include_input=False, include_context=False)
    if any(p["type"] == "json_invalid" for p in problems):
        return MalformedError("The body is not JSON.")
    return InvalidError(
        [
            FieldError(".".join(map(str, p["loc"])) or "body", p["msg"].removeprefix("Value error, "))
            for p in problems[:_MOST_FIELDS]
        ]
    )


def _without_caching(app: Starlette) -> Any:
    """Forbid caching of every answer that does not say otherwise; none is anything but what it says it is."""

    async def wrapped(scope: Any, receive: Any, send: Any) -> None:
        async def sending(message: Any) -> None:
            if message["type"] == "http.response.start":
                present = {name for name, _ in message["headers"]}
                message["headers"].append((b"x-content-type-options", b"nosniff"))
                if b"cache-control" not in present:
                    message["headers"].append((b"cache-control", b"no-store"))
            await send(message)

        await app(scope, receive, sending)

    return wrapped
