"""Secrets come from the parameter store, are remembered, and outlive its absence."""

import itertools
import random
from collections.abc import Sequence
from typing import Any

import pytest
from botocore.exceptions import EndpointConnectionError

from calibdb.errors import UnavailableError
from calibdb.store.secrets import MAX_ATTEMPTS, NAMES, SECRETS_TTL_S, Secrets
from tests.helpers.clock import Clock


class Ssm:
    def __init__(self) -> None:
        self.values = {"SESSION_SECRETS": "a,b", "CONTRIBUTOR_SECRET": "c"}
        self.reads = 0
        self.there = True

    def get_parameters(self, *, Names: Sequence[str], WithDecryption: bool) -> dict[str, Any]:  # noqa: N803
        assert WithDecryption
        assert set(Names) == {f"/calibdb/stack/{name}" for name in NAMES}
        self.reads += 1
        if not self.there:
            raise EndpointConnectionError(endpoint_url="https://ssm.invalid")
        return {"Parameters": [{"Name": f"/calibdb/stack/{k}", "Value": v} for k, v in self.values.items()]}


@pytest.fixture
def pauses(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Pauses between reads, which take no time."""
    pauses: list[float] = []
    monkeypatch.setattr("calibdb.store.secrets.time.sleep", pauses.append)
    return pauses


def test_read_once_and_again_after_five_minutes() -> None:
    ssm, clock = Ssm(), Clock()
    secrets = Secrets(lambda: ssm, "/calibdb/stack", clock)
    assert secrets() == secrets() == {"SESSION_SECRETS": "a,b", "CONTRIBUTOR_SECRET": "c"}
    assert ssm.reads == 1
    ssm.values["SESSION_SECRETS"] = "b,d,a"
    clock.now += SECRETS_TTL_S
    assert secrets()["SESSION_SECRETS"] == "b,d,a"


def test_cached_secrets_are_used_during_an_outage(pauses: list[float]) -> None:
    ssm, clock = Ssm(), Clock()
    secrets = Secrets(lambda: ssm, "/calibdb/stack", clock)
    before = secrets()
    ssm.there = False
    clock.now += SECRETS_TTL_S
    assert secrets() == before
    assert ssm.reads == 2
    with pytest.raises(UnavailableError):
        Secrets(lambda: ssm, "/calibdb/stack", clock)()
    assert len(pauses) == MAX_ATTEMPTS - 1
    assert max(pauses) <= 3.0


CROWD, QUOTA = 300, 40  # functions that start within a second; calls in a second that SSM gives an account
GATEWAY_S = 25.0  # s that are left of the gateway's 30 once a function has been loaded


def test_crowd_of_cold_starts_outlasts_the_quota_of_ssm(
    pauses: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """SSM refuses calls beyond its quota, a bucket of tokens that is refilled."""
    monkeypatch.setattr("calibdb.store.secrets.random", random.Random(0))
    ssm = Ssm()
    ssm.there = False
    reads = []
    for start in (number / CROWD for number in range(CROWD)):
        pauses.clear()
        with pytest.raises(UnavailableError):
            Secrets(lambda: ssm, "/calibdb/stack", Clock())()
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
