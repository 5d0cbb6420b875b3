"""API Gateway's part: an HTTP API made from the template. It knows no path and no function by name."""

import logging
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from urllib.parse import unquote

from tests.aws.emulator.events import Request, message, to_event, to_response
from tests.aws.emulator.functions import Function
from tests.aws.emulator.template import RouteSpec, Template
from tests.helpers.service.in_process import Response

# An HTTP API's integration timeout, seconds. Source: Amazon API Gateway developer guide, "Quotas for HTTP
# APIs".
INTEGRATION_TIMEOUT_S = 30.0

_log = logging.getLogger("tests.aws.emulator.gateway")


class Routes:
    """A template's routes: the most specific path that has the method wins, and there the method before ANY.

    A literal segment is more specific than a `{parameter}`. Source: Amazon API Gateway developer guide,
    "Create routes for HTTP APIs in API Gateway".
    """

    def __init__(self, routes: Iterable[RouteSpec]):
        self._routes = sorted(
            ((re.compile(re.sub(r"\{\w+\}", "[^/]+", route.path)), route) for route in routes),
            key=lambda entry: (_rank(entry[1].path), entry[1].method == "ANY"),
        )

    def match(self, method: str, path: str) -> RouteSpec | None:
        """Find the route of a request; `path` is percent-encoded and matched decoded, as an HTTP API does."""
        decoded = unquote(path)
        for pattern, route in self._routes:
            if route.method in (method, "ANY") and pattern.fullmatch(decoded):
                return route
        return None


def _rank(path: str) -> list[bool]:
    return [segment.startswith("{") for segment in path.split("/")]


class Gateway:
    """Gateway that turns requests into events, calls the functions, and turns their answers into responses.

    A preflight that a route matches, and `ANY` matches it, goes to the function, as users report, and with
    the function's own CORS headers; only the others are answered here.
    """

    def __init__(
        self,
        template: Template,
        functions: Mapping[str, Function],
    ):
        self.routes = Routes(template.routes)
        self._cors = template.cors
        self._functions = functions

    def handle(self, request: Request) -> Response:
        """Answer a request. Blocks as long as the function takes; safe from many threads at once."""
        origin = request.header("origin")
        if origin and request.method == "OPTIONS" and request.header("access-control-request-method"):
            if self.routes.match(request.method, request.path) is None:
                return Response(204, self._preflight_headers(), b"")
            return self._route(request)
        # An HTTP API with CORS configured replaces a function's CORS headers by its own.
        response = self._route(request)
        own = {key: value for key, value in response.headers.items() if not key.startswith("access-control-")}
        return replace(response, headers=own | (self._origin_headers() if origin else {}))

    def _route(self, request: Request) -> Response:
        route = self.routes.match(request.method, request.path)
        if route is None:
            return message(404, "Not Found")
        try:
            return to_response(self._functions[route.function](to_event(request, route.key)))
        except Exception:  # noqa: BLE001 - a handler may raise anything
            _log.exception("%s failed", route.function)
            return message(500, "Internal Server Error")

    def _preflight_headers(self) -> dict[str, str]:
        return self._origin_headers() | {
            "access-control-allow-methods": ",".join(self._cors["AllowMethods"]),
            "access-control-allow-headers": ",".join(self._cors["AllowHeaders"]),
            "access-control-max-age": str(self._cors["MaxAge"]),
        }

    def _origin_headers(self) -> dict[str, str]:
        return {
            "access-control-allow-origin": ",".join(self._cors["AllowOrigins"]),
            "access-control-expose-headers": ",".join(self._cors["ExposeHeaders"]),
        }
