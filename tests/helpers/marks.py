"""Marks of single cases of a parametrised test."""

from collections.abc import Iterable

import pytest
from _pytest.mark import ParameterSet

from tests.helpers.data import available, is_committed


def thorough(*cases: object) -> list[ParameterSet]:
    """Parameter sets of cases that only `make thorough` runs; a tuple is a case of several parameters."""
    mark = pytest.mark.thorough
    return [pytest.param(*(case if type(case) is tuple else (case,)), marks=mark) for case in cases]


def corner_sets(names: Iterable[str]) -> list[str | ParameterSet]:
    """Cases of corner sets: the committed ones, and for `make thorough` those that CALIBDB_DATA adds."""
    return [name if is_committed(name) else thorough(name)[0] for name in available(names)]
