"""Golden events: what the gateway makes of a request, against payload format 2.0 as AWS documents it."""

import base64
import json
from pathlib import Path
from typing import Any

import pytest

from tests.aws.emulator.events import Request, to_event
from tests.aws.emulator.gateway import Routes
from tests.aws.emulator.template import load

GOLDEN = sorted((Path(__file__).parent / "events").glob("*.json"))


def made(request: dict[str, Any]) -> dict[str, Any]:
    asked = Request(
        method=request["method"],
        path=request["path"],
        query=request.get("query", ""),
        headers=tuple((name, value) for name, value in request["headers"]),
        body=request.get("body", "").encode() + base64.b64decode(request.get("body_base64", "")),
        source_ip=request["source_ip"],
    )
    route = Routes(load({}).routes).match(asked.method, asked.path)
    assert route is not None
    event: dict[str, Any] = json.loads(json.dumps(to_event(asked, route.key)))
    return event


@pytest.mark.parametrize("path", GOLDEN, ids=lambda path: path.stem)
def test_events_have_no_member_that_the_gateway_would_not_send(path: Path) -> None:
    golden = json.loads(path.read_text())
    assert is_part(made(golden["request"]), golden["event"])


def is_part(some: Any, whole: Any) -> bool:
    """True if two values are equal but for members of mappings that the first one lacks."""
    if isinstance(some, dict):
        return isinstance(whole, dict) and all(n in whole and is_part(v, whole[n]) for n, v in some.items())
    return bool(some == whole)
