"""Conversions of one camera to many formats, which begin with the same fits."""

from collections.abc import Iterator

import pytest

from tests.helpers.solver.computed_once import computed_once


@pytest.fixture(autouse=True, scope="module")
def fits_made_once() -> Iterator[None]:
    with computed_once():
        yield
