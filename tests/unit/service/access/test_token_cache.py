"""Quotas: what counts, when it is written down, and who is stopped by what."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, cast

import pytest

from calibdb.access.plans import PLANS, Allowance, Counter, Plan, plan
from calibdb.access.tokens import ApiToken, secret_hash
from calibdb.errors import ForbiddenError, TooManyError, UnavailableError
from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store
from calibdb.store.quotas import Quotas
from calibdb.store.sqlite import Database, SqliteTable
from calibdb.store.token_cache import FLUSH_INTERVAL_S, LOOKUPS_PER_FLUSH, TOKEN_TTL_S, TokenCache
from tests.helpers.clock import Clock
from tests.unit.service.test_settings import ENVIRONMENT

SMALL = Plan(
    Allowance(sessions=5, views=9, lookups=10_000, poses=9),
    Allowance(sessions=2, views=4, lookups=6_000, poses=4),
)
PLANS_WITH_SMALL = PLANS | {"small": SMALL}
TOKEN = ApiToken("t", secret_hash("right"), plan="small")


class Tokens:
    def __init__(self) -> None:
        self.known = {"t": TOKEN}
        self.reads = 0

    def get(self, token_id: str) -> ApiToken | None:
        self.reads += 1
        return self.known.get(token_id)


class WatchedQuotas(Quotas):
    def __init__(self) -> None:
        super().__init__(SqliteTable(Database(None, lambda: 0.0)))
        self.writes: list[int] = []
        self.down = False
        self.failed = 0

    def add(self, token_id: str, kind: Counter, now: int, amount: int) -> int:
        if self.down:
            self.failed += 1
            raise UnavailableError("down")
        self.writes.append(amount)
        return super().add(token_id, kind, now, amount)


@pytest.fixture
def clock() -> Clock:
    return Clock(1_700_000_000 - 1_700_000_000 % 3600)


@pytest.fixture
def tokens() -> Tokens:
    return Tokens()


@pytest.fixture
def quotas() -> WatchedQuotas:
    return WatchedQuotas()


@pytest.fixture
def memory(tokens: Tokens, quotas: WatchedQuotas, clock: Clock) -> TokenCache:
    return TokenCache(tokens, quotas, clock, plans=PLANS_WITH_SMALL)


@pytest.fixture
def service(tokens: Tokens, quotas: WatchedQuotas, clock: Clock) -> Service:
    return service_with(PLANS_WITH_SMALL, tokens, quotas, clock)


def service_with(plans: dict[str, Plan], tokens: Tokens, quotas: WatchedQuotas, clock: Clock) -> Service:
    settings = Settings.from_environment(ENVIRONMENT)
    store = replace(Store.of(settings), tokens=cast(Any, tokens), quotas=quotas)
    return Service.build(settings, store, clock, plans=plans)


def look_up(memory: TokenCache, times: int = 1, source: str = "a") -> None:
    for _ in range(times):
        token = memory.get("t")
        assert token is not None
        memory.count_lookup(token, source)


def refusal(memory: TokenCache, clock: Clock, seconds: int) -> TooManyError:
    """Look up every `seconds` until it is refused."""
    for _ in range(1000):
        try:
            look_up(memory)
        except TooManyError as error:
            return error
        clock.now += seconds
    raise AssertionError("never refused")


def test_most_lookups_neither_read_nor_write(
    memory: TokenCache, tokens: Tokens, quotas: WatchedQuotas
) -> None:
    look_up(memory, 10 * LOOKUPS_PER_FLUSH)
    assert quotas.writes == [LOOKUPS_PER_FLUSH] * 9  # the tenth waits for the next lookup
    assert tokens.reads == 10


def test_lookups_of_a_server_are_written_only_when_it_asks(
    tokens: Tokens, quotas: WatchedQuotas, clock: Clock
) -> None:
    memory = TokenCache(tokens, quotas, clock, plans=PLANS_WITH_SMALL, in_background=True)
    look_up(memory, 4 * LOOKUPS_PER_FLUSH)
    assert (quotas.writes, tokens.reads) == ([], 1)
    memory.write_pending()
    memory.write_pending()
    assert quotas.writes == [4 * LOOKUPS_PER_FLUSH]


def test_rare_lookups_are_flushed_together(memory: TokenCache, quotas: WatchedQuotas, clock: Clock) -> None:
    for _ in range(60):  # one a minute: each reads the token anew, one in ten writes
        look_up(memory)
        clock.now += 60
    assert sum(quotas.writes) >= 50
    assert len(quotas.writes) <= 60 * 60 / FLUSH_INTERVAL_S


def test_an_hour_is_used_up_for_all_and_the_next_begins_anew(
    memory: TokenCache, quotas: WatchedQuotas, clock: Clock
) -> None:
    quotas.add("t", "lookups", int(clock.now), 9_900)  # by other instances
    refused = refusal(memory, clock, 1)
    assert int(refused.headers["Retry-After"]) == 3600 - clock.now % 3600
    assert clock.now % 3600 == LOOKUPS_PER_FLUSH  # found out when the first batch was written down
    clock.now += 3600 - LOOKUPS_PER_FLUSH
    look_up(memory)


def test_one_source_cannot_exhaust_the_shared_quota(memory: TokenCache, quotas: WatchedQuotas) -> None:
    look_up(memory, 6_000, "greedy")
    for _ in range(6_000):
        with pytest.raises(TooManyError):
            look_up(memory, source="greedy")
    look_up(memory, source="modest")
    assert sum(quotas.writes) <= 6_000


def test_failed_count_refuses_no_lookup(memory: TokenCache, quotas: WatchedQuotas, clock: Clock) -> None:
    quotas.down = True
    look_up(memory, LOOKUPS_PER_FLUSH + 5)
    assert quotas.failed == 1  # and not once for each lookup from there on
    quotas.down = False
    clock.now += int(TOKEN_TTL_S)
    look_up(memory)
    assert quotas.writes == [LOOKUPS_PER_FLUSH + 5]


def test_failed_count_of_an_earlier_hour_is_repeated_for_that_hour(
    memory: TokenCache, quotas: WatchedQuotas, clock: Clock
) -> None:
    look_up(memory)
    clock.now += 3600
    quotas.down = True
    look_up(memory, 5)
    assert quotas.failed == 1
    quotas.down = False
    clock.now += int(TOKEN_TTL_S)
    look_up(memory)
    clock.now += 3600
    look_up(memory)
    assert [used["lookups"] for used in quotas.use("t", int(clock.now)).values()] == [1, 6]


def test_wrong_secrets_cost_at_most_one_read_a_second(service: Service, tokens: Tokens, clock: Clock) -> None:
    service.api_token("cdb_t_right")
    assert tokens.reads == 1
    for second in range(1, 6):
        for n in range(50):
            with pytest.raises(ForbiddenError):
                service.api_token(f"cdb_t_wrong{n}")
            service.api_token("cdb_t_right")
        assert tokens.reads == 1 + second
        clock.now += 1


def test_threads_with_wrong_secrets_cost_one_read_together(
    service: Service, tokens: Tokens, clock: Clock
) -> None:
    service.api_token("cdb_t_right")
    clock.now += 5

    def refuse(n: int) -> None:
        with pytest.raises(ForbiddenError):
            service.api_token(f"cdb_t_wrong{n}")

    with ThreadPoolExecutor(16) as threads:
        list(threads.map(refuse, range(64)))
    assert tokens.reads == 2


def test_a_new_token_is_known_at_once(service: Service, tokens: Tokens) -> None:
    with pytest.raises(ForbiddenError):
        service.api_token("cdb_new_x")
    tokens.known["new"] = ApiToken("new", secret_hash("x"))
    assert service.api_token("cdb_new_x").id == "new"


def test_a_larger_plan_helps_within_a_minute(
    memory: TokenCache, tokens: Tokens, quotas: WatchedQuotas, clock: Clock
) -> None:
    quotas.add("t", "lookups", int(clock.now), 10_000)
    refusal(memory, clock, 0)
    tokens.known["t"] = replace(TOKEN, plan="partner")
    clock.now += int(TOKEN_TTL_S)
    look_up(memory)


def test_an_unlimited_plan_counts_nothing(memory: TokenCache, tokens: Tokens, quotas: WatchedQuotas) -> None:
    tokens.known["t"] = replace(TOKEN, plan="development")
    look_up(memory, 3 * LOOKUPS_PER_FLUSH)
    assert (quotas.writes, tokens.reads) == ([], 1)


def test_unknown_plan_is_the_smallest() -> None:
    assert plan("gone") is PLANS["free"]


def test_refused_call_takes_nothing_from_the_shared_quota(service: Service, quotas: WatchedQuotas) -> None:
    for _ in range(50):
        try:
            service.charge(TOKEN, "views", "192.0.2.1")
        except TooManyError:
            continue
    assert quotas.used("t", service.now) == {"views": 4}
    assert quotas.used("t", service.now, service.contributor("192.0.2.1", "t")) == {"views": 4}


def granted(service: Service, kind: Any, addresses: list[str]) -> list[bool]:
    token, out = service._tokens.get("t"), []
    assert token is not None
    for address in addresses:
        try:
            if kind == "lookups":
                service.count_lookup(token, address)
            else:
                service.charge(token, kind, address)
            out.append(True)
        except TooManyError:
            out.append(False)
    return out


@pytest.mark.parametrize(("kind", "each"), [("sessions", 2), ("views", 2), ("lookups", 5)])
def test_one_ipv6_line_has_the_share_of_three_users(
    tokens: Tokens, quotas: WatchedQuotas, clock: Clock, kind: str, each: int
) -> None:
    wide = Plan(Allowance(1_000, 1_000, 10_000, 1_000), Allowance(sessions=2, views=2, lookups=5, poses=2))
    service = service_with({"small": wide, "free": wide}, tokens, quotas, clock)
    subnets = [f"2001:db8:1:{n:x}::{host}" for n in range(256) for host in range(1, each + 1)]
    got = granted(service, kind, subnets)
    assert sum(got) == 3 * each
    assert got == sorted(got, reverse=True)
    assert sum(granted(service, kind, [f"2001:db8:2:0::{n:x}" for n in range(1, 100)])) == each
    assert all(granted(service, kind, [f"192.0.2.{n}" for n in range(50)]))
    assert all(granted(service, kind, [f"2001:db8:{n:x}::1" for n in range(3, 50)]))
