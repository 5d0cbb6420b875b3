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
NOW = 1_795_232_229.25
REQUEST_ID = "3f2b1c8e-9a4d-4e57-8b66-0c1d2e3f4a5b"


def made(request: dict[str, Any]) -> dict[str, Any]:
    body = request.get("body", "").encode() + base64.b64decode(request.get("body_base64", ""))
    asked = Request(
        method=request["method"],
        path=request["path"],
        query=request.get("query", ""),
        headers=tuple((name, value) for name, value in request["headers"]),
        body=body,
        source_ip=request["source_ip"],
    )
    match = Routes(load({}).routes).match(asked.method, asked.path)
    assert match is not None
    route, parameters = match
    passed: dict[str, Any] = json.loads(json.dumps(to_event(asked, route.key, parameters, REQUEST_ID, NOW)))
    return passed


@pytest.mark.parametrize("path", GOLDEN, ids=lambda path: path.stem)
def test_events_are_as_agreed(path: Path) -> None:
    golden = json.loads(path.read_text())
    assert made(golden["request"]) == golden["event"]
