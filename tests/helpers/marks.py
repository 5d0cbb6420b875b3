"""Marks of single cases of a parametrised test."""

import pytest
from _pytest.mark import ParameterSet


def thorough(*cases: object) -> list[ParameterSet]:
    """Parameter sets of cases that only `make thorough` runs; a tuple is a case of several parameters."""
    mark = pytest.mark.thorough
    return [pytest.param(*(case if type(case) is tuple else (case,)), marks=mark) for case in cases]
