"""Requests of strangers with tokens of their own, and a clock to turn."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from infra.ops.context import OpsContext
from infra.server.server import Server
from tests.helpers.clock import Clock
from tests.helpers.service.client import CAMERA, Answer, Client
from tests.helpers.service.stores import override_service

SITE = "https://example.org"


@contextmanager
def standing_clock(**more: Any) -> Iterator[Clock]:
    """Services with a clock that stands until it is turned, and with more that `Service.build` takes."""
    clock = Clock(time.time())
    with override_service(clock=clock, **more):
        yield clock


def make(client: Client, *origins: str, **named: object) -> Any:
    """Make a token for origins, or for programs and pages of the machine itself."""
    body = {"origins": origins or ("http://localhost",), **named}
    answer = client.call("POST", "/v1/tokens", body)
    assert answer.status == 201, answer.body
    return answer.json


def ask(client: Client, token: str, origin: str | None = None) -> Answer:
    headers = {} if origin is None else {"origin": origin}
    return client.call("POST", "/v1/lookup", {**CAMERA, "miss": "ok"}, token=token, headers=headers)


def manage(client: Client, method: str, made: Any, action: str = "", body: object = None) -> Answer:
    return client.call(method, f"/v1/tokens/self{action}", body, token=made["management_token"])


def rotate(client: Client, made: Any, **body: object) -> Any:
    return manage(client, "POST", made, "/rotate", body or None).json


def states(answer: Answer) -> dict[str, str]:
    assert answer.status == 200, answer.body
    return {origin["origin"]: origin["state"] for origin in answer.json["origins"]}


def context(stack: Server) -> OpsContext:
    return OpsContext.of(stack.environment, secret_known=True, echo=lambda _: None)
