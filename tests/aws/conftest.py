"""The whole stack emulated in memory, one for each module of tests."""

from collections.abc import Iterator

import pytest

from tests.aws.emulator import LocalStack
from tests.helpers.solver.computed_once import computed_once


@pytest.fixture(scope="module", autouse=True)
def results_of_the_solver() -> Iterator[None]:
    with computed_once():
        yield


@pytest.fixture(scope="module")
def stack() -> Iterator[LocalStack]:
    with LocalStack() as stack:
        yield stack
