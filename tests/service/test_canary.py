"""The canary against a served stack."""

import importlib.util
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import httpx
import pytest
from starlette.responses import Response
from starlette.types import Receive, Scope, Send

from calibdb.http import canary_capture
from infra.deploy import page_token
from infra.server.server import DEVELOPMENT_TOKEN, Server
from tests.helpers.service.published import store

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def canary() -> ModuleType:
    spec = importlib.util.spec_from_file_location("canary_app", ROOT / "functions/canary/app.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look their class up
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def site() -> Iterator[tuple[Server, str]]:
    with Server(environment={"CANARY_TOKEN": DEVELOPMENT_TOKEN}) as stack, stack.serve() as url:
        yield stack, url


def test_canary_calibrates_and_leaves_nothing(canary: ModuleType, site: tuple[Server, str]) -> None:
    stack, url = site
    before = list(stack.storage.objects.names(""))
    run = canary.handler({}, None)
    assert (run["ok"], run["failed_at"]) == (True, None)
    assert list(stack.storage.objects.names("")) == before, "neither views nor a calibration are kept"
    shown = httpx.get(f"{url}/healthz", params={"deep": "1"}, timeout=30)
    assert shown.status_code == 200, shown.text
    assert shown.json()["canary"] == run


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
    canary: ModuleType,
    site: tuple[Server, str],
    monkeypatch: pytest.MonkeyPatch,
    breaks: str,
    step: str,
) -> None:
    stack, url = site

    api = stack.app._api

    async def broken(scope: Scope, receive: Receive, send: Send) -> None:
        app = Response("secret", 500) if scope["path"] == breaks else api
        await app(scope, receive, send)

    monkeypatch.setattr(stack.app, "_api", broken)
    with pytest.raises(canary.CanaryError, match=rf"^{step}: "):
        canary.handler({}, None)
    shown = httpx.get(f"{url}/healthz", params={"deep": "1"}, timeout=30)
    assert shown.status_code == 503
    assert shown.json()["canary"]["failed_at"] == step


def test_canary_that_measures_wrongly_fails(
    canary: ModuleType, site: tuple[Server, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert site
    monkeypatch.setattr(canary_capture, "_MAX_FOCAL_ERROR", 1e-9)
    with pytest.raises(canary.CanaryError, match=r"^result: fx"):
        canary.handler({}, None)


def test_deployment_gives_the_canary_a_token_once(site: tuple[Server, str]) -> None:
    stack, _ = site
    kept = {}

    class Parameters:
        def get_parameters(self, *, Names: list[str], **_: object) -> Any:  # noqa: N803
            return {"Parameters": [{"Name": n, "Value": kept[n]} for n in Names if n in kept]}

        def put_parameter(self, *, Name: str, Value: str, Type: str, Overwrite: bool) -> None:  # noqa: N803
            assert (Type, Overwrite) == ("SecureString", True)
            kept[Name] = Value

    made = {
        "TableName": stack.environment["TABLE_NAME"],
        "KeypointBucketName": stack.environment["BUCKET_NAME"],
        "SiteUrl": "https://calibdb.example",
        "DistributionDomain": "d1.cloudfront.net",
    }
    for _ in range(2):
        page_token.give_canary(made, "us-east-1", Parameters(), "calibdb")
    ((name, value),) = kept.items()
    assert name == "/calibdb/calibdb/CANARY_TOKEN"
    token = store(stack).tokens.get(value.split("_")[1])
    assert (token.plan, token.origins) == ("free", ("https://calibdb.example", "https://d1.cloudfront.net"))
