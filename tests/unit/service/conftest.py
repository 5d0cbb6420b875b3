"""The environment of a function, in that of this process."""

from collections.abc import Iterator

import pytest

from calibdb.service import Service
from tests.unit.service.test_settings import ENVIRONMENT


@pytest.fixture
def function_environment(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Variables of a function. A process reads them once, so they are forgotten before and after."""
    for name, value in ENVIRONMENT.items():
        monkeypatch.setenv(name, value)
    Service.forget()
    yield
    Service.forget()
