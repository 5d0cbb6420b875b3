"""Services: their identity, and the tickets that they give."""

import pytest

from calibdb.access.tokens import ApiToken
from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store
from tests.helpers.clock import Clock
from tests.unit.service.test_settings import ENVIRONMENT

SETTINGS = Settings.from_environment(ENVIRONMENT)


@pytest.fixture
def clock() -> Clock:
    return Clock(1_700_000_000.9)


@pytest.fixture
def service(clock: Clock) -> Service:
    return Service.build(SETTINGS, Store.of(SETTINGS), clock, lambda size: "ab" * size)


def test_sessions_sort_by_their_start(service: Service, clock: Clock) -> None:
    token = ApiToken("dev", "")
    first = service.ticket(token, None).sid
    clock.now += 1
    assert (first, len(first)) == ("6553f100" + "ab" * 8, 24)
    assert service.ticket(token, None).sid > first


def test_ticket_of_an_origin_token_is_bound_to_its_page(service: Service) -> None:
    page = "https://a.example"
    assert service.ticket(ApiToken("t", "", (page,)), page).origin == page
    assert service.ticket(ApiToken("t", ""), page).origin is None


def test_equal_environments_are_one_service() -> None:
    assert Service.of(ENVIRONMENT) is Service.of(dict(ENVIRONMENT))
    assert Service.of(ENVIRONMENT) is not Service.of({**ENVIRONMENT, "TABLE_NAME": "other"})
