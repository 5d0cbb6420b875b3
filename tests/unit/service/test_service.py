"""Memory of a service between requests: a token for half a minute, and nothing else."""

import math
from dataclasses import replace
from typing import Any, cast

import pytest

from calibdb.access.tokens import ApiToken, secret_hash
from calibdb.errors import ForbiddenError
from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store
from tests.unit.service.test_settings import ENVIRONMENT

SETTINGS = Settings.from_environment(ENVIRONMENT)


class Tokens:
    """Tokens in a dictionary, that counts how often it is read."""

    def __init__(self) -> None:
        self.known = {"dev": ApiToken("dev", secret_hash("local"))}
        self.reads = 0

    def get(self, token_id: str) -> ApiToken | None:
        self.reads += 1
        return self.known.get(token_id)


class Clock:
    now = 1_700_000_000.9

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def tokens() -> Tokens:
    return Tokens()


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def service(tokens: Tokens, clock: Clock) -> Service:
    store = replace(Store.of(SETTINGS), tokens=cast(Any, tokens))
    return Service.build(SETTINGS, store, clock, lambda size: "ab" * size)


def test_a_token_is_read_twice_a_minute(service: Service, tokens: Tokens, clock: Clock) -> None:
    for _ in range(3):
        assert service.api_token("cdb_dev_local").id == "dev"
    assert tokens.reads == 1
    clock.now += 30
    service.api_token("cdb_dev_local")
    assert tokens.reads == 2


def test_a_revoked_token_is_refused_within_a_minute(service: Service, tokens: Tokens, clock: Clock) -> None:
    service.api_token("cdb_dev_local")
    tokens.known.clear()
    clock.now += 60
    with pytest.raises(ForbiddenError):
        service.api_token("cdb_dev_local")


def test_a_remembered_token_still_wants_its_secret(service: Service) -> None:
    service.api_token("cdb_dev_local")
    for wrong in ("cdb_dev_Local", "cdb_dev_l", "dev", ""):
        with pytest.raises(ForbiddenError):
            service.api_token(wrong)


def test_a_new_token_is_known_at_once(service: Service, tokens: Tokens) -> None:
    with pytest.raises(ForbiddenError):
        service.api_token("cdb_new_x")
    tokens.known["new"] = ApiToken("new", secret_hash("x"))
    assert service.api_token("cdb_new_x").id == "new"


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


@pytest.mark.usefixtures("function_environment")
def test_environment_is_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    service = Service.of_process()
    monkeypatch.setenv("TABLE_NAME", "other")
    assert Service.of_process() is service
    Service.forget()
    assert Service.of_process().settings.table_name == "other"


@pytest.mark.usefixtures("function_environment")
def test_equal_secrets_read_again_are_one_service(monkeypatch: pytest.MonkeyPatch) -> None:
    current = {"SESSION_SECRETS": "a,b"}
    monkeypatch.setattr(
        "calibdb.service.with_secrets", lambda environment: ({**environment, **current}, -math.inf)
    )
    service = Service.of_process()
    assert Service.of_process() is service
    current["SESSION_SECRETS"] = "c,a"
    assert Service.of_process() is not service
    assert Service.of_process().settings.session_secrets == ("c", "a")
