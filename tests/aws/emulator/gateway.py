"""API Gateway's part: an HTTP API made from the template. It knows no path and no function by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from tests.aws.emulator.events import Request, Response, message, to_event, to_response
from tests.aws.emulator.functions import Function, FunctionError
from tests.aws.emulator.routes import Routes
from tests.aws.emulator.template import CorsSpec, Template

# An HTTP API's integration timeout, seconds. Source: Amazon API Gateway developer guide, "Quotas for HTTP
# APIs".
INTEGRATION_TIMEOUT_S = 30.0


class Gateway:
    """Gateway that turns requests into events, calls the functions, and turns their answers into responses.

    `answers_preflights`: whether every preflight is answered here, as API Gateway's guide can be read. By
    default one that a route matches, and `ANY` matches it, goes to the function, as users report, and with
    the function's own CORS headers; only the others are answered here.
    """

    def __init__(
        self,
        template: Template,
        functions: Mapping[str, Function],
        clock: Callable[[], float],
        new_id: Callable[[], str],
        answers_preflights: bool = False,
    ):
        self.routes = Routes(template.routes)
        self._cors = template.cors
        self._functions = functions
        self._clock = clock
        self._new_id = new_id
        self._answers_preflights = answers_preflights

    def handle(self, request: Request) -> Response:
        """Answer a request. Blocks as long as the function takes; safe from many threads at once."""
        origin = request.header("origin")
        if self._cors and origin and _is_preflight(request):
            if self._answers_preflights or self.routes.match(request.method, request.path) is None:
                return Response(204, _preflight_headers(self._cors, origin))
            return self._route(request)
        return self._with_cors(self._route(request), origin)

    def _with_cors(self, response: Response, origin: str | None) -> Response:
        if not self._cors:
            return response
        return replace(response, headers=_with_cors(response.headers, self._cors, origin))

    def _route(self, request: Request) -> Response:
        match = self.routes.match(request.method, request.path)
        if match is None:
            return message(404, "Not Found")
        request_id = self._new_id()
        event = to_event(request, match.key, match.parameters, request_id, self._clock())
        try:
            return to_response(self._functions[match.route.function](event, request_id))
        except FunctionError:
            return message(500, "Internal Server Error")  # logged where it happened


def _is_preflight(request: Request) -> bool:
    return request.method == "OPTIONS" and request.header("access-control-request-method") is not None


def _preflight_headers(cors: CorsSpec, origin: str) -> dict[str, str]:
    headers = _origin_headers(cors, origin)
    if headers:
        headers["access-control-allow-methods"] = ",".join(cors.allow_methods)
        headers["access-control-allow-headers"] = ",".join(cors.allow_headers)
        if cors.max_age is not None:
            headers["access-control-max-age"] = str(cors.max_age)
    return headers


def _with_cors(headers: Mapping[str, str], cors: CorsSpec, origin: str | None) -> dict[str, str]:
    """Replace a function's CORS headers by the gateway's, as an HTTP API with CORS configured does."""
    own = {key: value for key, value in headers.items() if not key.startswith("access-control-")}
    return own | (_origin_headers(cors, origin) if origin else {})


def _origin_headers(cors: CorsSpec, origin: str) -> dict[str, str]:
    if "*" in cors.allow_origins:
        headers = {"access-control-allow-origin": "*"}
    elif origin in cors.allow_origins:
        headers = {"access-control-allow-origin": origin, "vary": "origin"}
    else:
        return {}
    if cors.expose_headers:
        headers["access-control-expose-headers"] = ",".join(cors.expose_headers)
    return headers
