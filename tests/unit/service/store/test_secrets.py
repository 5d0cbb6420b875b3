"""Secrets come from the parameter store, are remembered, and outlive its absence."""

from typing import Any

import pytest
from botocore.exceptions import EndpointConnectionError

from calibdb.errors import UnavailableError
from calibdb.store.secrets import SECRETS_TTL_S, Secrets, with_secrets


class Ssm:
    def __init__(self) -> None:
        self.values = {"SESSION_SECRETS": "a,b", "CONTRIBUTOR_SECRET": "c"}
        self.reads = 0
        self.there = True

    def get_parameters_by_path(self, *, Path: str, WithDecryption: bool) -> dict[str, Any]:  # noqa: N803
        assert WithDecryption
        self.reads += 1
        if not self.there:
            raise EndpointConnectionError(endpoint_url="https://ssm.invalid")
        return {"Parameters": [{"Name": f"{Path}/{k}", "Value": v} for k, v in self.values.items()]}


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_read_once_and_again_after_five_minutes() -> None:
    ssm, clock = Ssm(), Clock()
    secrets = Secrets(lambda: ssm, "/calibdb/stack", clock)
    assert secrets() == secrets() == {"SESSION_SECRETS": "a,b", "CONTRIBUTOR_SECRET": "c"}
    assert ssm.reads == 1
    ssm.values["SESSION_SECRETS"] = "b,d,a"
    clock.now += SECRETS_TTL_S
    assert secrets()["SESSION_SECRETS"] == "b,d,a"


def test_cached_secrets_are_used_during_an_outage() -> None:
    ssm, clock = Ssm(), Clock()
    secrets = Secrets(lambda: ssm, "/calibdb/stack", clock)
    before = secrets()
    ssm.there = False
    clock.now += SECRETS_TTL_S
    assert secrets() == before
    with pytest.raises(UnavailableError):
        Secrets(lambda: ssm, "/calibdb/stack", clock)()


def test_secrets_without_path_come_from_the_environment() -> None:
    environment = {"SECRETS_PATH": "", "SESSION_SECRETS": "x"}
    assert with_secrets(environment) is environment
