"""Routing of an HTTP API by method and path.

Source: Amazon API Gateway developer guide, "Create routes for HTTP APIs in API Gateway".
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from urllib.parse import unquote

from tests.aws.emulator.template import RouteSpec


@dataclass(frozen=True)
class Match:
    """A route and the values of its path's parameters."""

    route: RouteSpec
    parameters: dict[str, str]

    @property
    def key(self) -> str:
        """The `routeKey` of the event."""
        return f"{self.route.method} {self.route.path}"


class Routes:
    """A template's routes: the most specific path that has the method wins, and there the method before ANY.

    A literal segment is more specific than a `{parameter}`.
    """

    def __init__(self, routes: Iterable[RouteSpec]):
        self._routes = sorted(
            ((re.compile(re.sub(r"\{(\w+)\}", r"(?P<\1>[^/]+)", route.path)), route) for route in routes),
            key=lambda entry: (_rank(entry[1].path), entry[1].method == "ANY"),
        )

    def match(self, method: str, path: str) -> Match | None:
        """Find the route of a request; `path` is percent-encoded and matched decoded, as an HTTP API does."""
        decoded = unquote(path)
        for pattern, route in self._routes:
            if route.method in (method, "ANY") and (found := pattern.fullmatch(decoded)):
                return Match(route, found.groupdict())
        return None


def _rank(path: str) -> list[bool]:
    return [segment.startswith("{") for segment in path.split("/")]
