"""The canary against a served stack."""

from collections.abc import Iterator

import pytest
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from calibdb.http import canary_capture
from functions.canary import app as canary
from infra.deploy import aws, page_token
from infra.server.server import DEVELOPMENT_TOKEN, Server
from tests.helpers.aws import account
from tests.helpers.service.client import Client
from tests.helpers.service.published import store


@pytest.fixture
def stack() -> Iterator[Server]:
    with Server(environment={"CANARY_TOKEN": DEVELOPMENT_TOKEN}) as stack, stack.serve():
        yield stack


def test_canary_calibrates_and_leaves_nothing(stack: Server) -> None:
    before = list(stack.storage.objects.names(""))
    run = canary.handler({}, None)
    assert (run["ok"], run["failed_at"]) == (True, None)
    assert list(stack.storage.objects.names("")) == before, "neither views nor a calibration are kept"
    shown = Client(stack).call("GET", "/healthz", query="deep=1")
    assert (shown.status, shown.json["canary"]) == (200, run)


@pytest.mark.parametrize(
    ("breaks", "step"),
    [
        ("/v1/lookup", "lookup"),
        ("/v1/auth", "open"),
        ("/v1/session/pose", "pose"),
        ("/v1/session/views", "view"),
    ],
)
def test_canary_says_at_which_step_it_failed(
    stack: Server,
    monkeypatch: pytest.MonkeyPatch,
    breaks: str,
    step: str,
) -> None:

    api = stack.app._api

    async def broken(scope: Scope, receive: Receive, send: Send) -> None:
        app = Response("secret", 500) if scope["path"] == breaks else api
        await app(scope, receive, send)

    monkeypatch.setattr(stack.app, "_api", broken)
    with pytest.raises(canary.CanaryError, match=rf"^{step}: "):
        canary.handler({}, None)
    shown = Client(stack).call("GET", "/healthz", query="deep=1")
    assert (shown.status, shown.json["canary"]["failed_at"]) == (503, step)


def test_canary_that_measures_wrongly_fails(stack: Server, monkeypatch: pytest.MonkeyPatch) -> None:
    assert stack
    monkeypatch.setattr(canary_capture, "_MAX_FOCAL_ERROR", 1e-9)
    with pytest.raises(canary.CanaryError, match=r"^result: fx"):
        canary.handler({}, None)


def test_deployment_gives_the_canary_a_token_once(stack: Server) -> None:
    made = {
        "TableName": stack.environment["TABLE_NAME"],
        "KeypointBucketName": stack.environment["BUCKET_NAME"],
        "SiteUrl": "https://calibdb.example",
        "DistributionDomain": "d1.cloudfront.net",
    }
    with account():
        deployed = aws.Account("calibdb", "us-east-1")
        for _ in range(2):
            page_token.give_canary(made, deployed)
        name = "/calibdb/calibdb/CANARY_TOKEN"
        parameter = deployed.client("ssm").get_parameter(Name=name, WithDecryption=True)["Parameter"]
    assert (parameter["Type"], parameter["Version"]) == ("SecureString", 1)
    token = store(stack).tokens.get(parameter["Value"].split("_")[1])
    assert (token.plan, token.origins) == ("free", ("https://calibdb.example", "https://d1.cloudfront.net"))
