"""Source address behind CloudFront: taken from its header, and not from a forged one."""

from dataclasses import replace
from typing import Any, cast

import pytest
from starlette.requests import Request

from calibdb.http.call import Call
from calibdb.settings import Settings
from tests.unit.service.test_settings import ENVIRONMENT

SECRET = "e" * 32
SETTINGS = Settings.from_environment({**ENVIRONMENT, "EDGE_SECRET": SECRET})


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
def test_the_edge_names_the_caller_and_not_what_the_caller_invented(forwarded: str) -> None:
    assert address(forwarded, SECRET) == "192.0.2.7"


@pytest.mark.parametrize("shown", [None, "", "e" * 31, "ü"])
def test_nobody_else_is_believed(shown: str | None) -> None:
    assert address("192.0.2.7, 198.51.100.9", shown) == "198.51.100.9"


def test_without_a_secret_nobody_is_believed() -> None:
    assert address("192.0.2.7, 198.51.100.9", "", replace(SETTINGS, edge_secret=None)) == "198.51.100.9"


def test_an_edge_that_names_nobody() -> None:
    assert address("198.51.100.9", SECRET) == "198.51.100.9"
