"""Services: their identity, the tickets that they give, and how long a process keeps one."""

import math

import pytest

from calibdb.access.tokens import ApiToken
from calibdb.service import Service
from calibdb.settings import Settings
from calibdb.store import Store
from tests.helpers.clock import Clock
from tests.unit.service.test_settings import ENVIRONMENT

SETTINGS = Settings.from_environment(ENVIRONMENT)


def test_sessions_sort_by_their_start() -> None:
    clock = Clock(1_700_000_000.9)
    service = Service.build(SETTINGS, Store.of(SETTINGS), clock, lambda size: "ab" * size)
    token = ApiToken("dev", "")
    first = service.ticket(token, None).sid
    clock.now += 1
    assert (first, len(first)) == ("6553f100" + "ab" * 8, 24)
    assert service.ticket(token, None).sid > first


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
