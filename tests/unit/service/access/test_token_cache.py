"""Quotas: what counts, when it is written down, and who is stopped by what."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import pytest

from calibdb.access.plans import KINDS, PLANS, Allowance, Counter, Plan, multiplied, plan
from calibdb.access.tokens import ApiToken, secret_hash
from calibdb.errors import ForbiddenError, TooManyError, UnavailableError
from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store
from calibdb.store.quotas import Quotas
from calibdb.store.sqlite import Database, SqliteTable
from calibdb.store.token_cache import FLUSH_INTERVAL_S, LOOKUPS_PER_FLUSH, TOKEN_TTL_S
from tests.helpers.clock import Clock
from tests.unit.service.test_settings import ENVIRONMENT

SMALL = Plan(
    Allowance(sessions=5, views=9, lookups=10_000, poses=9),
    Allowance(sessions=2, views=4, lookups=6_000, poses=4),
)
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


class World:
    """A service with one token, over storage that is watched."""

    def __init__(self, small: Plan = SMALL, *, in_background: bool = False) -> None:
        self.clock = Clock(1_700_000_000 - 1_700_000_000 % 3600)
        self.tokens, self.quotas = Tokens(), WatchedQuotas()
        settings = Settings.from_environment(ENVIRONMENT)
        store = replace(Store.of(settings), tokens=self.tokens, quotas=self.quotas)
        plans = PLANS | {"small": small}
        self.service = Service.build(settings, store, self.clock, plans=plans, in_background=in_background)
        self.memory = self.service._tokens

    def look_up(self, times: int = 1, source: str = "a", every_s: int = 0) -> None:
        for _ in range(times):
            token = self.memory.get("t")
            self.memory.count_lookup(token, source)
            self.clock.now += every_s


@pytest.fixture
def world() -> World:
    return World()


def test_most_lookups_neither_read_nor_write(world: World) -> None:
    world.look_up(10 * LOOKUPS_PER_FLUSH)
    assert world.quotas.writes == [LOOKUPS_PER_FLUSH] * 9  # the tenth waits for the next lookup
    assert world.tokens.reads == 10


def test_lookups_of_a_server_are_written_only_when_it_asks() -> None:
    world = World(in_background=True)
    world.look_up(4 * LOOKUPS_PER_FLUSH)
    assert (world.quotas.writes, world.tokens.reads) == ([], 1)
    world.memory.write_pending()
    world.memory.write_pending()
    assert world.quotas.writes == [4 * LOOKUPS_PER_FLUSH]


def test_rare_lookups_are_flushed_together(world: World) -> None:
    world.look_up(60, every_s=60)  # each reads the token again, one in ten writes
    assert sum(world.quotas.writes) >= 50
    assert len(world.quotas.writes) <= 60 * 60 / FLUSH_INTERVAL_S


def test_an_hour_is_used_up_for_all_and_the_next_begins_anew(world: World) -> None:
    world.quotas.add("t", "lookups", int(world.clock.now), 9_900)  # by other instances
    with pytest.raises(TooManyError) as refused:
        world.look_up(1000, every_s=1)
    assert int(refused.value.headers["Retry-After"]) == 3600 - world.clock.now % 3600
    assert world.clock.now % 3600 == LOOKUPS_PER_FLUSH  # found out when the first batch was written down
    world.clock.now += 3600 - LOOKUPS_PER_FLUSH
    world.look_up()


def test_one_source_cannot_exhaust_the_shared_quota(world: World) -> None:
    world.look_up(6_000, "greedy")
    for _ in range(6_000):
        with pytest.raises(TooManyError):
            world.look_up(source="greedy")
    world.look_up(source="modest")
    assert sum(world.quotas.writes) <= 6_000


def test_failed_count_refuses_no_lookup(world: World) -> None:
    world.quotas.down = True
    world.look_up(LOOKUPS_PER_FLUSH + 5)
    assert world.quotas.failed == 1  # and not once for each lookup from there on
    world.quotas.down = False
    world.clock.now += int(TOKEN_TTL_S)
    world.look_up()
    assert world.quotas.writes == [LOOKUPS_PER_FLUSH + 5]


def test_failed_count_of_an_earlier_hour_is_repeated_for_that_hour(world: World) -> None:
    world.look_up()
    world.clock.now += 3600
    world.quotas.down = True
    world.look_up(5)
    assert world.quotas.failed == 1
    world.quotas.down = False
    world.clock.now += int(TOKEN_TTL_S)
    world.look_up()
    world.clock.now += 3600
    world.look_up()
    assert [used["lookups"] for used in world.quotas.use("t", int(world.clock.now)).values()] == [1, 6]


def test_wrong_secrets_cost_at_most_one_read_a_second(world: World) -> None:
    world.service.api_token("cdb_t_right")
    assert world.tokens.reads == 1
    for second in range(1, 6):
        for n in range(50):
            with pytest.raises(ForbiddenError):
                world.service.api_token(f"cdb_t_wrong{n}")
            world.service.api_token("cdb_t_right")
        assert world.tokens.reads == 1 + second
        world.clock.now += 1


def test_threads_with_wrong_secrets_cost_one_read_together(world: World) -> None:
    world.service.api_token("cdb_t_right")
    world.clock.now += 5

    def refuse(n: int) -> None:
        with pytest.raises(ForbiddenError):
            world.service.api_token(f"cdb_t_wrong{n}")

    with ThreadPoolExecutor(16) as threads:
        list(threads.map(refuse, range(64)))
    assert world.tokens.reads == 2


def test_a_new_token_is_known_at_once(world: World) -> None:
    with pytest.raises(ForbiddenError):
        world.service.api_token("cdb_new_x")
    world.tokens.known["new"] = ApiToken("new", secret_hash("x"))
    assert world.service.api_token("cdb_new_x").id == "new"


def test_a_larger_plan_helps_within_a_minute(world: World) -> None:
    world.quotas.add("t", "lookups", int(world.clock.now), 10_000)
    with pytest.raises(TooManyError):
        world.look_up(1000)
    world.tokens.known["t"] = replace(TOKEN, plan="partner")
    world.clock.now += int(TOKEN_TTL_S)
    world.look_up()


def test_an_unlimited_plan_counts_nothing(world: World) -> None:
    world.tokens.known["t"] = replace(TOKEN, plan="development")
    world.look_up(3 * LOOKUPS_PER_FLUSH)
    assert (world.quotas.writes, world.tokens.reads) == ([], 1)


def test_unknown_plan_is_the_smallest() -> None:
    assert plan("gone") is PLANS["free"]


def test_factor_multiplies_what_users_share_and_not_what_each_has() -> None:
    plans = multiplied([("page", 50), ("partner", 2), ("development", 3)])
    assert plans["page"].each == PLANS["page"].each
    for kind in KINDS:
        assert getattr(plans["page"].together, kind) == 50 * getattr(PLANS["page"].together, kind)
    partner = plans["partner"]
    assert partner.each == partner.together, "of one user"
    assert partner.together.sessions == 10_000
    assert plans | {name: PLANS[name] for name in ("page", "partner")} == PLANS
    with pytest.raises(ValueError, match="there is no plan pages"):
        multiplied([("pages", 2)])


def test_environment_names_factors() -> None:
    settings = Settings.from_environment({**ENVIRONMENT, "PLAN_FACTORS": "page=50,free=2"})
    assert settings.plan_factors == (("page", 50), ("free", 2))
    assert Service.make(settings)._plans["page"].together.sessions == 50_000


def test_refused_call_takes_nothing_from_the_shared_quota(world: World) -> None:
    for _ in range(50):
        try:
            world.service.charge(TOKEN, "views", "192.0.2.1")
        except TooManyError:
            continue
    assert world.quotas.used("t", world.service.now) == {"views": 4}
    assert world.quotas.used("t", world.service.now, world.service.contributor("192.0.2.1", "t")) == {
        "views": 4
    }


def granted(service: Service, kind: Any, addresses: list[str]) -> list[bool]:
    token, out = service.api_token("cdb_t_right"), []
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
def test_one_ipv6_line_has_the_share_of_three_users(kind: str, each: int) -> None:
    wide = Plan(Allowance(1_000, 1_000, 10_000, 1_000), Allowance(sessions=2, views=2, lookups=5, poses=2))
    service = World(wide).service
    subnets = [f"2001:db8:1:{n:x}::{host}" for n in range(256) for host in range(1, each + 1)]
    got = granted(service, kind, subnets)
    assert sum(got) == 3 * each
    assert got == sorted(got, reverse=True)
    assert sum(granted(service, kind, [f"2001:db8:2:0::{n:x}" for n in range(1, 100)])) == each
    assert all(granted(service, kind, [f"192.0.2.{n}" for n in range(50)]))
    assert all(granted(service, kind, [f"2001:db8:{n:x}::1" for n in range(3, 50)]))
