"""Source address behind CloudFront: taken from its header, and not from a forged one."""

from dataclasses import replace
from typing import Any, cast

import pytest
from starlette.requests import Request

from calibdb.http.call import Call
from calibdb.settings import Settings
from tests.unit.service.test_settings import ENVIRONMENT

SECRET, NEXT = "e" * 32, "f" * 32
SETTINGS = Settings.from_environment({**ENVIRONMENT, "EDGE_SECRETS": f"{SECRET},{NEXT}"})


class Service:
    def __init__(self, settings: Settings) -> None:
        self.settings = settings


def address(forwarded: str, shown: str | None, settings: Settings = SETTINGS) -> str:
    headers = [(b"x-forwarded-for", forwarded.encode())]
    if shown is not None:
        headers.append((b"x-calibdb-edge", shown.encode("latin-1")))
    scope = {"type": "http", "headers": headers, "client": ("198.51.100.9", 0)}
    return Call(Request(scope), b"", cast(Any, Service(settings))).address


@pytest.mark.parametrize("forwarded", ["192.0.2.7, 198.51.100.9", "203.0.113.1, 192.0.2.7, 198.51.100.9"])
@pytest.mark.parametrize("shown", [SECRET, NEXT])
def test_address_is_the_edges_not_a_forged_header(forwarded: str, shown: str) -> None:
    assert address(forwarded, shown) == "192.0.2.7"


@pytest.mark.parametrize("shown", [None, "", "e" * 31, "ü"])
def test_address_header_without_secret_is_ignored(shown: str | None) -> None:
    assert address("192.0.2.7, 198.51.100.9", shown) == "198.51.100.9"


def test_address_is_the_gateways_without_secrets_or_hops() -> None:
    assert address("192.0.2.7, 198.51.100.9", "", replace(SETTINGS, edge_secrets=())) == "198.51.100.9"
    assert address("198.51.100.9", SECRET) == "198.51.100.9"


def test_requests_with_an_unknown_secret_are_counted(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("AWS_LAMBDA_RUNTIME_API", "127.0.0.1:9001")
    address("192.0.2.7, 198.51.100.9", "g" * 32)
    assert '"UnknownEdges":1' in capsys.readouterr().out
    address("192.0.2.7, 198.51.100.9", None)  # the API's own address
    address("192.0.2.7, 198.51.100.9", SECRET)
    assert capsys.readouterr().out == ""
