"""Results of the solver that the tests of a module share."""

from collections.abc import Iterator

import pytest

from tests.helpers.solver.computed_once import computed_once


@pytest.fixture(scope="module", autouse=True)
def results_of_the_solver() -> Iterator[None]:
    with computed_once():
        yield
