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
        self.clock = lambda: 1.7e9


def address(forwarded: str, shown: str | None, settings: Settings = SETTINGS) -> str:
    headers = [(b"x-forwarded-for", forwarded.encode())]
    if shown is not None:
        headers.append((b"x-calibdb-edge", shown.encode("latin-1")))
    scope = {"type": "http", "headers": headers, "client": ("198.51.100.9", 0)}
    return Call(Request(scope), b"", cast(Any, Service(settings))).address


@pytest.mark.parametrize("forwarded", ["192.0.2.7, 198.51.100.9", "203.0.113.1, 192.0.2.7, 198.51.100.9"])
def test_address_is_the_edges_not_a_forged_header(forwarded: str) -> None:
    assert address(forwarded, SECRET) == "192.0.2.7"


@pytest.mark.parametrize("shown", [None, "", "e" * 31, "ü"])
def test_address_header_without_secret_is_ignored(shown: str | None) -> None:
    assert address("192.0.2.7, 198.51.100.9", shown) == "198.51.100.9"


def test_address_header_is_ignored_where_no_secret_is_set() -> None:
    assert address("192.0.2.7, 198.51.100.9", "", replace(SETTINGS, edge_secrets=())) == "198.51.100.9"


def test_edge_without_address_falls_back_to_the_gateway() -> None:
    assert address("198.51.100.9", SECRET) == "198.51.100.9"


def test_both_secrets_of_a_rotation_are_taken() -> None:
    for shown in (SECRET, NEXT):
        assert address("192.0.2.7, 198.51.100.9", shown) == "192.0.2.7"


def test_requests_with_an_unknown_secret_are_counted(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("AWS_LAMBDA_RUNTIME_API", "127.0.0.1:9001")
    address("192.0.2.7, 198.51.100.9", "g" * 32)
    assert '"UnknownEdges":1' in capsys.readouterr().out
    address("192.0.2.7, 198.51.100.9", None)  # the API's own address
    address("192.0.2.7, 198.51.100.9", SECRET)
    assert capsys.readouterr().out == ""
