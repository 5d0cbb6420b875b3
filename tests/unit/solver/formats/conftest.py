"""Conversions of one camera to many formats, which begin with the same fits."""

from collections.abc import Iterator

import pytest

from calibsolver.formats import convert
from tests.helpers.solver.fits import fit_once


@pytest.fixture(autouse=True, scope="package")
def fits_made_once() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(convert, "fit", fit_once)
        yield
