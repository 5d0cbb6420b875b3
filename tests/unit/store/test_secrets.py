"""Secrets come from the parameter store, are remembered, and outlive its absence."""

import heapq
import itertools
import random
import threading
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest
from botocore.exceptions import ClientError, EndpointConnectionError

from calibdb.errors import UnavailableError
from calibdb.store.secrets import MAX_ATTEMPTS, NAMES, SECRETS_TTL_S, Secrets
from tests.helpers.clock import Clock
from tests.helpers.marks import thorough


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
    assert ssm.reads == 2  # who has some does not wait for others
    pauses: list[float] = []
    with pytest.raises(UnavailableError):
        Secrets(lambda: ssm, "/calibdb/stack", clock, pauses.append)()
    assert len(pauses) == MAX_ATTEMPTS - 1
    assert max(pauses) <= 3.0


CROWD, QUOTA = 300, 40  # functions that start within a second; calls in a second that SSM gives an account
GATEWAY_S = 25.0  # s that are left of the gateway's 30 once a function has been loaded


class Simulation:
    """Threads on a clock of its own: when all of them sleep it goes on, to the first that wakes up."""

    def __init__(self, threads: int) -> None:
        self.now = 0.0
        self._awake = threads
        self._until: list[tuple[float, int, threading.Event]] = []
        self._number = itertools.count()
        self._turn = threading.Lock()

    def sleep(self, seconds: float) -> None:
        alarm = threading.Event()  # one each: who sleeps on is not woken
        with self._turn:
            heapq.heappush(self._until, (self.now + seconds, next(self._number), alarm))
            self._advance()
        alarm.wait()

    def leave(self) -> None:
        with self._turn:
            self._advance()

    def _advance(self) -> None:
        self._awake -= 1
        if not self._awake and self._until:
            self.now, _, alarm = heapq.heappop(self._until)
            self._awake = 1
            alarm.set()


class Limited(Ssm):
    """SSM that refuses the calls beyond its quota: a bucket of tokens, refilled as time goes by."""

    def __init__(self, simulation: Simulation) -> None:
        super().__init__()
        self._simulation = simulation
        self._tokens, self._filled = float(QUOTA), 0.0
        self._lock = threading.Lock()
        self.refused = 0

    def get_parameters(self, **asked: Any) -> dict[str, Any]:
        with self._lock:
            now = self._simulation.now
            self._tokens = min(QUOTA, self._tokens + QUOTA * (now - self._filled))
            self._filled = now
            if self._tokens < 1:
                self.refused += 1
                raise ClientError({"Error": {"Code": "ThrottlingException"}}, "GetParameters")
            self._tokens -= 1
            return super().get_parameters(**asked)


@pytest.mark.parametrize("seed", [0, *thorough(1, 2)])
def test_crowd_of_cold_starts_outlasts_the_quota_of_ssm(seed: int) -> None:
    simulation = Simulation(CROWD)
    ssm, rng = Limited(simulation), random.Random(seed)

    def start(number: int) -> float:
        simulation.sleep(number / CROWD)  # all within a second
        read = Secrets(lambda: ssm, "/calibdb/stack", Clock(), simulation.sleep, rng.uniform)
        try:
            assert read()["SESSION_SECRETS"] == "a,b"
            return simulation.now - number / CROWD
        finally:
            simulation.leave()

    with ThreadPoolExecutor(CROWD) as pool:
        waited = list(pool.map(start, range(CROWD)))
    assert ssm.refused > CROWD  # so that it was a crowd
    assert max(waited) < GATEWAY_S
