"""Secrets come from the parameter store, are remembered, and outlive its absence."""

import itertools
import random
import time
from collections.abc import Sequence
from typing import Any

import pytest
from botocore.exceptions import EndpointConnectionError

from calibdb.errors import UnavailableError
from calibdb.store import secrets


class Ssm:
    def __init__(self) -> None:
        self.values = {"SESSION_SECRETS": "a,b", "CONTRIBUTOR_SECRET": "c"}
        self.reads = 0
        self.there = True

    def get_parameters(self, *, Names: Sequence[str], WithDecryption: bool) -> dict[str, Any]:  # noqa: N803
        assert WithDecryption
        assert set(Names) == {f"/calibdb/stack/{name}" for name in secrets.NAMES}
        self.reads += 1
        if not self.there:
            raise EndpointConnectionError(endpoint_url="https://ssm.invalid")
        return {"Parameters": [{"Name": f"/calibdb/stack/{k}", "Value": v} for k, v in self.values.items()]}


ENVIRONMENT = {"SECRETS_PATH": "/calibdb/stack", "AWS_REGION": "eu-central-1"}


@pytest.fixture(autouse=True)
def ssm(monkeypatch: pytest.MonkeyPatch) -> Ssm:
    ssm = Ssm()
    monkeypatch.setattr("calibdb.store.aws.ssm", lambda _: ssm)
    monkeypatch.setattr(secrets, "_known", {})
    return ssm


@pytest.fixture
def pauses(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Pauses between reads, which take no time."""
    pauses: list[float] = []
    monkeypatch.setattr("calibdb.store.secrets.time.sleep", pauses.append)
    return pauses


def test_secrets_are_read_again_after_five_minutes(ssm: Ssm) -> None:
    begun = time.monotonic()
    variables, until = secrets.with_secrets(ENVIRONMENT)
    assert variables == {**ENVIRONMENT, "SESSION_SECRETS": "a,b", "CONTRIBUTOR_SECRET": "c"}
    assert begun + 300 <= until <= time.monotonic() + 300
    ssm.values["SESSION_SECRETS"] = "b,d,a"
    assert secrets.with_secrets(ENVIRONMENT)[0]["SESSION_SECRETS"] == "b,d,a"


def test_known_secrets_are_used_during_an_outage(
    ssm: Ssm, pauses: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    before, _ = secrets.with_secrets(ENVIRONMENT)
    ssm.there = False
    assert secrets.with_secrets(ENVIRONMENT)[0] == before
    assert ssm.reads == 2
    monkeypatch.setattr(secrets, "_known", {})
    with pytest.raises(UnavailableError):
        secrets.with_secrets(ENVIRONMENT)
    assert len(pauses) == secrets.MAX_ATTEMPTS - 1
    assert max(pauses) <= 3.0


CROWD, QUOTA = 300, 40  # functions that start within a second; calls in a second that SSM gives an account
GATEWAY_S = 25.0  # s that are left of the gateway's 30 once a function has been loaded


def test_crowd_of_cold_starts_outlasts_the_quota_of_ssm(
    ssm: Ssm, pauses: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """SSM refuses calls beyond its quota, a bucket of tokens that is refilled."""
    monkeypatch.setattr("calibdb.store.secrets.random", random.Random(0))
    ssm.there = False
    reads = []
    for start in (number / CROWD for number in range(CROWD)):
        pauses.clear()
        with pytest.raises(UnavailableError):
            secrets.with_secrets(ENVIRONMENT)
        reads += [(time, start) for time in itertools.accumulate(pauses, initial=start)]
    reads.sort()
    waited: dict[float, float] = {}
    left, filled, refused = float(QUOTA), 0.0, 0
    for now, start in reads:
        if start in waited:
            continue
        left, filled = min(QUOTA, left + QUOTA * (now - filled)), now
        if left < 1:
            refused += 1
            continue
        left -= 1
        waited[start] = now - start
    assert refused > CROWD  # so that it was a crowd
    assert len(waited) == CROWD
    assert max(waited.values()) < GATEWAY_S
