"""HTTP application of a function: routes from `Call` to a Starlette response."""

import hashlib
import json
import logging
import os
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from http import HTTPStatus
from typing import Any, cast
from urllib.parse import urljoin

from pydantic import BaseModel
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from calibdb.errors import PROBLEMS, CalibdbError, DeniedReadError
from calibdb.http import metrics
from calibdb.http.call import RATE_LIMITS, InLoopError
from calibdb.http.call import Call as Call
from calibdb.service import Service

_PROBLEM = "application/problem+json"
_TEXT = ["text/", "application/json", _PROBLEM]  # everything else leaves as base64
_GATEWAY: Any = {"api_gateway_base_path": "/", "text_mime_types": _TEXT, "exclude_headers": []}

_log = logging.getLogger(__name__)
_HOST_HEADERS = ("host", "x-forwarded-port")
_DETAILS: dict[int, str] = {
    HTTPStatus.NOT_FOUND: "The API has no such path.",
    HTTPStatus.METHOD_NOT_ALLOWED: "This path allows {Allow}.",
}

IN_THREAD = "calibdb.in_thread"  # in a request's scope: an `InThread`, in a server
InThread = Callable[[Callable[[], Response]], Awaitable[Response]]
Endpoint = Callable[[Call], Response]


def json_response(model: BaseModel, status: int = 200, headers: Mapping[str, str] | None = None) -> Response:
    """JSON response of `model`."""
    return Response(model.model_dump_json(), status, headers, "application/json")


def tagged_response(request: Request, model: BaseModel, headers: Mapping[str, str]) -> Response:
    """JSON response of `model` with its ETag; 304 if the request has that one."""
    content = model.model_dump_json().encode()
    tag = f'"{hashlib.sha256(content).hexdigest()[:32]}"'
    headers = {**headers, "ETag": tag}
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=headers)
    return Response(content, 200, headers, "application/json")


def route(path: str, *, is_quick: bool = False, **methods: Endpoint) -> Route:
    """Route of one path: its methods in capitals, each with its endpoint; HEAD as GET.

    `is_quick`: a server runs the endpoint in its event loop, and again in a thread after
    `Call.require_thread`.
    """

    async def endpoint(request: Request) -> Response:
        method = methods["GET" if request.method == "HEAD" else request.method]
        body = await request.body()
        in_thread: InThread | None = request.scope.get(IN_THREAD)
        if in_thread is None:
            return method(Call(request, body, _service()))
        if is_quick:
            with suppress(InLoopError):
                return method(Call(request, body, _service(), in_loop=True))
        return await in_thread(lambda: method(Call(request, body, _service())))

    return Route(path, endpoint, methods=list(methods))


def application(*routes: Route) -> Starlette:
    """Starlette application of `routes`; errors become problem+json without a trace."""
    app = Starlette(
        routes=list(routes),
        exception_handlers={
            CalibdbError: _on_calibdb_error,
            HTTPException: _on_http_exception,
            Exception: _on_unhandled,
        },
    )
    app.router.redirect_slashes = False  # a path with an extra slash does not exist
    return app


class handler:  # noqa: N801 - as Lambda calls it
    """The Lambda handler of `routes`: payload format 2.0 in and out."""

    def __init__(self, *routes: Route) -> None:
        if "AWS_LAMBDA_RUNTIME_API" in os.environ:
            import mangum.handlers  # noqa: F401 - now, since Lambda starts a function faster than it runs it
        self.routes = routes
        self._app = with_default_headers(application(*routes))

    def __call__(self, event: dict[str, Any], context: Any) -> dict[str, Any]:
        """Response to an event."""
        from mangum.handlers import HTTPGateway

        gateway = HTTPGateway(_without_host(event), context, _GATEWAY)
        return gateway(_run(self._app, gateway.scope, gateway.body))


def _run(app: Any, scope: Any, body: bytes) -> Any:
    """Run the application on one request, without an event loop."""
    messages: list[Any] = []

    async def receive() -> Any:
        return {"type": "http.request", "body": body, "more_body": False}

    async def send(message: Any) -> None:
        messages.append(message)

    try:
        app(scope, receive, send).send(None)
    except StopIteration:
        pass
    except Exception:
        if not messages:
            raise
        _log.exception("the request failed")
    else:
        raise RuntimeError("an endpoint waits asynchronously")
    start, *rest = messages
    content = b"".join(message.get("body", b"") for message in rest)
    return {"status": start["status"], "headers": start["headers"], "body": content}


def _without_host(event: dict[str, Any]) -> dict[str, Any]:
    """Event without its host: Mangum fails on a malformed one."""
    headers = {k: v for k, v in (event.get("headers") or {}).items() if k.lower() not in _HOST_HEADERS}
    return {**event, "headers": headers}


def _service() -> Service:
    return Service.of_process()


def problem_response(error: CalibdbError) -> Response:
    """Response of an error, its type an address of the guidance page's site."""
    document = error.problem()
    document["type"] = urljoin(os.environ.get("GUIDANCE_URL", ""), PROBLEMS + error.kind)
    content = json.dumps(document, ensure_ascii=False).encode()
    return Response(content, error.status, error.headers, _PROBLEM)


async def _on_calibdb_error(_: Request, raised: Exception) -> Response:
    error = cast("CalibdbError", raised)
    if error.status >= HTTPStatus.INTERNAL_SERVER_ERROR:
        _log.error("%s", error.detail, exc_info=error)
        denied = {"DeniedReads": 1} if isinstance(error, DeniedReadError) else {}
        metrics.count(reason=error.kind, Errors=1, **denied)
    return problem_response(error)


async def _on_http_exception(_: Request, raised: Exception) -> Response:
    error = cast("HTTPException", raised)
    title = HTTPStatus(error.status_code).phrase.capitalize()
    headers = dict(error.headers or {})
    if "Allow" in headers:
        headers["Allow"] = ", ".join(sorted(headers["Allow"].split(", ")))
    detail = _DETAILS.get(error.status_code, error.detail).format_map(headers)
    problem = CalibdbError(detail, kind=title.lower().replace(" ", "-"), headers=headers)
    problem.status, problem.title = error.status_code, title
    return problem_response(problem)


async def _on_unhandled(_: Request, __: Exception) -> Response:
    # Starlette raises it again once this is sent, and Mangum logs it with its trace.
    metrics.count(reason="internal", Errors=1)
    return problem_response(
        CalibdbError("The service failed to handle the request; the request itself may be valid.")
    )


#: of every origin, since tokens say which they admit
PREFLIGHT = {
    "Access-Control-Allow-Origin": "*",
    "Access-Control-Allow-Methods": "GET,POST,PATCH,DELETE,OPTIONS",
    "Access-Control-Allow-Headers": "authorization,content-type,accept,if-none-match",
    "Access-Control-Max-Age": "86400",
}


def with_default_headers(app: Starlette) -> Any:
    """Respond to preflights, and add default headers and rate limits.

    An HTTP API passes preflights to the function, whose `ANY` route they match.
    """

    async def wrapped(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] == "http" and scope["method"] == "OPTIONS":
            await Response(status_code=204, headers=PREFLIGHT)(scope, receive, send)
            return

        async def sending(message: Any) -> None:
            if message["type"] == "http.response.start":
                present = {name for name, _ in message["headers"]}
                message["headers"].append((b"x-content-type-options", b"nosniff"))
                if b"cache-control" not in present:
                    message["headers"].append((b"cache-control", b"no-store"))
                for name, value in scope.get(RATE_LIMITS, {}).items():
                    if name.lower().encode() not in present:
                        message["headers"].append((name.lower().encode(), value.encode()))
            await send(message)

        await app(scope, receive, sending)

    return wrapped
